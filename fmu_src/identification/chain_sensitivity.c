#include "chain_sensitivity.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS = IT2_RULE_PARAMETERS * IT2_MAX_RULES + CHAIN_MAX_KNOBS };

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

/* A fit is of (10) itself: which range it holds for comes out in the end. */
static void begin(struct walker *walker, const struct chain_parameters *parameters)
{
    chain_prepare(&walker->chain, parameters);
    it2_prepare(&walker->chain.core, parameters->rule, parameters->ruleCount, IT2_EVERYWHERE);
    chain_reset(&walker->chain, &walker->state, parameters);
}

/* Brings what stands behind the core to rest with the core at the displacement. */
static void begin_respond(struct walker *walker, const struct chain_parameters *parameters, double core)
{
    const struct creep *creep = &walker->chain.creep;
    struct chain_state *state = &walker->state;
    double y = core;

    for (int i = 0; i < creep->count; i++) {
        state->creep.s[i] = core - parameters->displacementZero + parameters->initialCreep;
        y += creep->gain[i] * state->creep.s[i];
    }
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

size_t chain_predict(const struct chain_parameters *parameters, const struct chain_record *record,
                     double *measured, double *core_input, double *core_output)
{
    struct walker walker;

    begin(&walker, parameters);
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

/* The play operator whose weight the knob is, or PLAY_MAX. */
static size_t weighed(const struct chain_knob *knob)
{
    const size_t first = offsetof(struct chain_parameters, play) + offsetof(struct play_element, weight);
    const size_t distance = knob->offset - first; /* of what stands before: far too large */

    return distance % sizeof(struct play_element) ? PLAY_MAX : distance / sizeof(struct play_element);
}

/* Both begin with the core where that of the unchanged chain does. Returns the derivative by the knob of
 * where the core really begins. */
static double begin_pair(struct pair *pair, const struct chain_parameters *parameters, double core,
                         const struct chain_knob *knob)
{
    struct chain_parameters changed = *parameters;
    double *value = (double *)((char *)&changed + knob->offset);
    const double centre = *value;
    double begins[2];

    *value = centre - knob->step;
    begin(&pair->below, &changed);
    begins[0] = pair->below.state.core.y;
    begin_respond(&pair->below, &changed, core);
    *value = centre + knob->step;
    begin(&pair->above, &changed);
    begins[1] = pair->above.state.core.y;
    begin_respond(&pair->above, &changed, core);
    return (begins[1] - begins[0]) / (2.0 * knob->step);
}

/* How the voltage at which the stage rests before the first tick acts: by it, derivatives of the states
 * before the core, which begin with it, and of the core's input. */
struct rest {
    struct chain_state d;
    double by_input;                  /* of that voltage, by the core's input at rest */
    struct it2_partials f;            /* of the core at rest */
    double rules[IT2_RULE_PARAMETERS * IT2_MAX_RULES]; /* of the core's output there */
    double play[PLAY_MAX];
};

static void rest_of(struct rest *rest, const struct walker *walker)
{
    const struct it2 *core = &walker->chain.core;
    const struct play *play = &walker->chain.play;
    const double y = walker->state.core.y;
    double slope = 1.0;

    *rest = (struct rest){ .by_input = 0.0 };
    it2_gradient(core, y, it2_solve(core, y, y), rest->rules, &rest->f);
    delay_reset(&rest->d.delay, 1.0);
    slew_reset(&rest->d.slew, 1.0);
    lag_reset(&rest->d.lag, 1.0);
    for (int j = 0; j < play->count; j++) {
        rest->d.play.p[j] = 1.0;
        rest->play[j] = walker->state.play.p[j];
        slope += play->element[j].weight;
    }
    rest->by_input = 1.0 / slope;
}

/* Derivative of the core's input by a knob before it. A play operator's weight multiplies its output,
 * and the core comes next: there are many, and they need no difference. */
static double drive_derivative(struct pair *pair, const struct chain_knob *knob,
                               const struct play_state *play, double voltage)
{
    const size_t operator = weighed(knob);

    if (operator < PLAY_MAX)
        return play->p[operator];
    return (chain_drive(&pair->above.chain, &pair->above.state, voltage) -
            chain_drive(&pair->below.chain, &pair->below.state, voltage)) /
           (2.0 * knob->step);
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

/* What the stages behind the core make of derivatives of its output. `straight` is the displacement before
 * the static curve. */
static void respond_columns(const struct chain *chain, struct columns *d, double straight, double *row)
{
    if (chain->effects & CHAIN_CREEP)
        creep_columns(&chain->creep, d, row);
    if (chain->effects & CHAIN_RESONANCE)
        resonance_columns(&chain->resonance, d, row);
    const double slope = chain_bend_tangent(chain, straight, 1.0);
    for (int c = 0; c < d->count; c++)
        row[c] *= slope;
}

/* Derivatives of the states behind the core by those of its displacement at rest. */
static void begin_columns(struct columns *d, const struct chain *chain, const double *core)
{
    double slope = 1.0;

    for (int i = 0; i < chain->creep.count; i++) {
        memcpy(d->creep[i], core, (size_t)d->count * sizeof *core);
        slope += chain->creep.gain[i];
    }
    for (int c = 0; c < d->count; c++)
        d->resonance[0][c] = d->resonance[1][c] = slope * core[c];
}

/* Derivative of the voltage at rest by a play operator's weight, or by where the core begins. */
static double rest_derivative(const struct rest *rest, const struct chain_knob *knob, double core)
{
    const size_t operator = weighed(knob);

    if (operator < PLAY_MAX)
        return -rest->by_input * rest->play[operator];
    return rest->by_input * core * (1.0 - rest->f.dy) / rest->f.dx;
}

size_t chain_sensitivity(const struct chain_parameters *parameters, const struct chain_record *record,
                         const struct chain_knob *knobs, int count, double *measured,
                         double *sensitivity)
{
    const int rules = IT2_RULE_PARAMETERS * parameters->ruleCount;
    const int columns = rules + count;
    double core[COLUMNS] = { 0.0 };    /* derivatives of the core's output */
    double resting[COLUMNS] = { 0.0 }; /* of the voltage at rest */
    double gradient[IT2_RULE_PARAMETERS * IT2_MAX_RULES];
    struct it2_partials f;
    struct walker walker;
    struct rest rest;
    struct pair *pairs = malloc((size_t)(count > 0 ? count : 1) * sizeof *pairs);
    struct columns *d = malloc(sizeof *d);
    size_t k = 0;

    if (!pairs || !d || count > CHAIN_MAX_KNOBS)
        goto end;
    *d = (struct columns){ .count = columns };
    begin(&walker, parameters);
    rest_of(&rest, &walker);
    for (int i = 0; i < rules; i++)
        resting[i] = -rest.by_input * rest.rules[i] / rest.f.dx;
    for (int j = 0; j < count; j++) {
        core[rules + j] = begin_pair(&pairs[j], parameters, walker.state.core.y, &knobs[j]);
        resting[rules + j] = rest_derivative(&rest, &knobs[j], core[rules + j]);
    }
    begin_columns(d, &walker.chain, core);
    for (; k < record->samples; k++) {
        const struct chain_surroundings around = at(parameters, record, k);
        double *row = sensitivity + k * (size_t)columns;
        double x = record->voltage[k];
        const double by_rest = chain_drive_tangent(&walker.chain, &walker.state, &x, &rest.d, 0.0);
        const double y = it2_gradient(&walker.chain.core, walker.state.core.y, x, gradient, &f);
        walker.state.core.y = y;
        for (int c = 0; c < columns; c++)
            core[c] = f.dy * core[c] + f.dx * by_rest * resting[c];
        for (int i = 0; i < rules; i++)
            core[i] += gradient[i];
        for (int j = 0; j < count; j++)
            if (knobs[j].before_core)
                core[rules + j] += f.dx * drive_derivative(&pairs[j], &knobs[j], &walker.state.play,
                                                           record->voltage[k]);
        memcpy(row, core, (size_t)columns * sizeof *row);
        const double straight = chain_respond_affine(&walker.chain, &walker.state, y, &around);
        measured[k] = chain_measure(&walker.chain, chain_bend(&walker.chain, straight), around.time);
        respond_columns(&walker.chain, d, straight, row);
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
