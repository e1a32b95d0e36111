#include "chain_sensitivity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS = IT2_RULE_PARAMETERS * IT2_MAX_RULES + CHAIN_MAX_KNOBS + 1 };

/* A chain and where it is. */
struct walker {
    struct chain chain;
    struct chain_state state;
};

/* Two chains with one parameter a little below and above. */
struct pair {
    struct walker below, above;
};

/* Derivatives of the states behind the core, a column for each of what is fitted. */
struct columns {
    int count;
    double creep[CREEP_MAX][COLUMNS];
    double resonance[2][COLUMNS];
};

static void begin(struct walker *walker, const struct chain_parameters *parameters,
                  const struct chain_start *start)
{
    struct chain *chain = &walker->chain;
    struct chain_state *state = &walker->state;

    chain_prepare(chain, parameters);
    *state = (struct chain_state){ 0 };
    delay_reset(&state->delay, start->voltage);
    slew_reset(&state->slew, start->voltage);
    const double within =
        chain->effects & CHAIN_SATURATION ? saturation_step(&chain->saturation, start->voltage)
                                          : start->voltage;
    lag_reset(&state->lag, within);
    play_recall(&chain->play, &state->play, chain_history(parameters));
    play_step(&chain->play, &state->play, within);
    it2_reset(&state->core, start->displacement);
    for (int i = 0; i < chain->creep.count; i++)
        state->creep.s[i] = start->displacement + parameters->initialCreep;
    double y = start->displacement;
    for (int i = 0; i < chain->creep.count; i++)
        y += chain->creep.gain[i] * state->creep.s[i];
    resonance_reset(&state->resonance, y);
}

static struct chain_surroundings at(const struct chain_parameters *parameters,
                                    const struct chain_record *record, size_t k)
{
    const double time = (double)(record->first_tick + (int64_t)k) * parameters->sampleTime;

    return (struct chain_surroundings){ record->force[k], record->temperature[k], time };
}

static double respond(struct walker *walker, double core, const struct chain_surroundings *around)
{
    const double y = chain_respond(&walker->chain, &walker->state, core, around);

    return chain_measure(&walker->chain, y, around->time);
}

size_t chain_predict(const struct chain_parameters *parameters, const struct chain_start *start,
                     const struct chain_record *record, double *measured, double *core_input,
                     double *core_output)
{
    struct walker walker;

    begin(&walker, parameters, start);
    for (size_t k = 0; k < record->samples; k++) {
        const struct chain_surroundings around = at(parameters, record, k);
        core_input[k] = chain_drive(&walker.chain, &walker.state, record->voltage[k]);
        core_output[k] = it2_step(&walker.chain.core, &walker.state.core, core_input[k]);
        measured[k] = respond(&walker, core_output[k], &around);
        if (!isfinite(measured[k]))
            return k;
    }
    return record->samples;
}

static void begin_pair(struct pair *pair, const struct chain_parameters *parameters,
                       const struct chain_start *start, const struct chain_knob *knob)
{
    struct chain_parameters changed = *parameters;
    double *value = (double *)((char *)&changed + knob->offset);
    const double centre = *value;

    *value = centre - knob->step;
    begin(&pair->below, &changed, start);
    *value = centre + knob->step;
    begin(&pair->above, &changed, start);
}

static double drive_difference(struct pair *pair, double voltage)
{
    return chain_drive(&pair->above.chain, &pair->above.state, voltage) -
           chain_drive(&pair->below.chain, &pair->below.state, voltage);
}

static double respond_difference(struct pair *pair, double core, const struct chain_surroundings *around)
{
    return respond(&pair->above, core, around) - respond(&pair->below, core, around);
}

/* Creep of a row of derivatives: linear, so by its own equation. */
static void creep_columns(const struct creep *stage, struct columns *d, double *row)
{
    double x[COLUMNS];

    memcpy(x, row, (size_t)d->count * sizeof *x);
    for (int i = 0; i < stage->count; i++) {
        double *s = d->creep[i];
        for (int c = 0; c < d->count; c++) {
            s[c] += stage->rate[i] * (x[c] - s[c]);
            row[c] += stage->gain[i] * s[c];
        }
    }
}

static void resonance_columns(const struct resonance *stage, struct columns *d, double *row)
{
    double *last = d->resonance[0];
    double *before = d->resonance[1];

    for (int c = 0; c < d->count; c++) {
        const double y = stage->a1 * last[c] + stage->a2 * before[c] + stage->b * row[c];
        before[c] = last[c];
        last[c] = row[c] = y;
    }
}

/* What the stages behind the core make of derivatives of its output. `displacement` is that before the
 * reading's curve. */
static void respond_columns(const struct chain *chain, struct columns *d, double displacement,
                            double *row)
{
    if (chain->effects & CHAIN_CREEP)
        creep_columns(&chain->creep, d, row);
    if (chain->effects & CHAIN_RESONANCE)
        resonance_columns(&chain->resonance, d, row);
    const double slope = chain_measure_tangent(chain, displacement, 1.0);
    for (int c = 0; c < d->count; c++)
        row[c] *= slope;
}

/* Derivatives of the states behind the core by start.displacement, the last column. */
static void begin_columns(struct columns *d, const struct chain *chain, int count)
{
    double slope = 1.0;

    *d = (struct columns){ .count = count };
    for (int i = 0; i < chain->creep.count; i++) {
        d->creep[i][count - 1] = 1.0;
        slope += chain->creep.gain[i];
    }
    d->resonance[0][count - 1] = d->resonance[1][count - 1] = slope;
}

size_t chain_sensitivity(const struct chain_parameters *parameters, const struct chain_start *start,
                         const struct chain_record *record, const struct chain_knob *knobs, int count,
                         double *measured, double *sensitivity)
{
    const int rules = IT2_RULE_PARAMETERS * parameters->ruleCount;
    const int columns = rules + count + 1;
    double core[COLUMNS] = { 0.0 }; /* derivatives of the core's output */
    double gradient[IT2_RULE_PARAMETERS * IT2_MAX_RULES];
    struct it2_partials f;
    struct walker walker;
    struct pair *pairs = malloc((size_t)(count > 0 ? count : 1) * sizeof *pairs);
    struct columns *d = malloc(sizeof *d);
    size_t k = 0;

    if (!pairs || !d || count > CHAIN_MAX_KNOBS)
        goto end;
    begin(&walker, parameters, start);
    for (int j = 0; j < count; j++)
        begin_pair(&pairs[j], parameters, start, &knobs[j]);
    begin_columns(d, &walker.chain, columns);
    core[columns - 1] = 1.0;
    for (; k < record->samples; k++) {
        const struct chain_surroundings around = at(parameters, record, k);
        double *row = sensitivity + k * (size_t)columns;
        const double x = chain_drive(&walker.chain, &walker.state, record->voltage[k]);
        const double y = it2_gradient(&walker.chain.core, walker.state.core.y, x, gradient, &f);
        walker.state.core.y = y;
        for (int c = 0; c < columns; c++)
            core[c] *= f.dy;
        for (int i = 0; i < rules; i++)
            core[i] += gradient[i];
        for (int j = 0; j < count; j++)
            if (knobs[j].before_core)
                core[rules + j] += f.dx * drive_difference(&pairs[j], record->voltage[k]) /
                                   (2.0 * knobs[j].step);
        memcpy(row, core, (size_t)columns * sizeof *row);
        const double displacement = chain_respond(&walker.chain, &walker.state, y, &around);
        measured[k] = chain_measure(&walker.chain, displacement, around.time);
        respond_columns(&walker.chain, d, displacement, row);
        for (int j = 0; j < count; j++)
            if (!knobs[j].before_core)
                row[rules + j] += respond_difference(&pairs[j], y, &around) / (2.0 * knobs[j].step);
        if (!isfinite(measured[k]) || !isfinite(f.dy))
            break;
    }
end:
    free(d);
    free(pairs);
    return k;
}
