#include "chain_sensitivity.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS = IT2_RULE_PARAMETERS * IT2_MAX_RULES + CHAIN_MAX_KNOBS };

#define NEWTON_STEPS 50
#define NEGLIGIBLE 1e-14
#define STEEPEST 0.999

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
static void prepare(struct chain *chain, const struct chain_parameters *parameters)
{
    chain_prepare(chain, parameters);
    it2_prepare(&chain->core, parameters->rule, parameters->ruleCount, IT2_EVERYWHERE);
}

/* Brings what stands before the core to rest at the voltage; returns the core's input. */
static double begin_drive(struct walker *walker, const struct chain_parameters *parameters,
                          double voltage)
{
    struct chain *chain = &walker->chain;
    struct chain_state *state = &walker->state;
    double x = voltage;

    prepare(chain, parameters);
    *state = (struct chain_state){ 0 };
    delay_reset(&state->delay, x);
    slew_reset(&state->slew, x);
    if (chain->effects & CHAIN_SATURATION)
        x = saturation_step(&chain->saturation, x);
    lag_reset(&state->lag, x);
    play_recall(&chain->play, &state->play, x, chain_history(parameters));
    return play_step(&chain->play, &state->play, x);
}

/* Takes *y to the displacement that the core keeps at the input, by Newton's method. Returns whether it
 * is found within the range from there: a core that is being fitted need not have one; *y stays then. */
static bool equilibrium(const struct it2 *core, double input, double range, double *displacement)
{
    double y = *displacement;

    for (int i = 0; i < NEWTON_STEPS; i++) {
        const struct it2_partials f = it2_partials(core, y, input);
        const double change = it2_evaluate(core, y, input) - y;
        /* outside the range where it contracts the core has other, unstable equilibria */
        const double step = f.dy < STEEPEST ? change / (1.0 - f.dy) : change;
        y += step;
        if (!(fabs(y - *displacement) <= range))
            break;
        if (fabs(step) <= NEGLIGIBLE * range && f.dy < STEEPEST) {
            *displacement = y;
            return true;
        }
    }
    return false;
}

/* Brings the core to the displacement, and what stands behind it. */
static void begin_respond(struct walker *walker, const struct chain_parameters *parameters, double core)
{
    const struct creep *creep = &walker->chain.creep;
    struct chain_state *state = &walker->state;
    double y = core;

    it2_reset(&state->core, core);
    for (int i = 0; i < creep->count; i++) {
        state->creep.s[i] = core - parameters->displacementZero + parameters->initialCreep;
        y += creep->gain[i] * state->creep.s[i];
    }
    resonance_reset(&state->resonance, y);
}

/* Where the core is while the displacement rests at initialDisplacement. */
static double at_rest(const struct chain *chain, const struct chain_parameters *parameters)
{
    struct chain_state state;

    return chain_reset_response(chain, &state, parameters);
}

/* The core's input before the first tick, and whether the core keeps its displacement under it. */
struct start {
    double input;
    bool at_rest;
};

static struct start begin(struct walker *walker, const struct chain_parameters *parameters,
                          double voltage)
{
    const double range = parameters->displacementMax - parameters->displacementMin;
    struct start start = { .input = begin_drive(walker, parameters, voltage) };
    double core = at_rest(&walker->chain, parameters);

    start.at_rest = equilibrium(&walker->chain.core, start.input, range, &core);
    begin_respond(walker, parameters, core);
    return start;
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

    begin(&walker, parameters, record->voltage[0]);
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

/* What begins with the core: its input, and its displacement where it keeps none. */
struct beginning {
    double input;
    double core;
};

static struct beginning begin_one(struct walker *walker, const struct chain_parameters *parameters,
                                  double voltage, double core)
{
    struct beginning result = { .input = begin_drive(walker, parameters, voltage) };

    begin_respond(walker, parameters, core);
    result.core = at_rest(&walker->chain, parameters);
    return result;
}

/* The core of both begins where that of the unchanged chain does. Returns the derivatives by the knob. */
static struct beginning begin_pair(struct pair *pair, const struct chain_parameters *parameters,
                                   double voltage, double core, const struct chain_knob *knob)
{
    struct chain_parameters changed = *parameters;
    double *value = (double *)((char *)&changed + knob->offset);
    const double centre = *value;

    *value = centre - knob->step;
    const struct beginning below = begin_one(&pair->below, &changed, voltage, core);
    *value = centre + knob->step;
    const struct beginning above = begin_one(&pair->above, &changed, voltage, core);
    return (struct beginning){ (above.input - below.input) / (2.0 * knob->step),
                               (above.core - below.core) / (2.0 * knob->step) };
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

size_t chain_sensitivity(const struct chain_parameters *parameters, const struct chain_record *record,
                         const struct chain_knob *knobs, int count, double *measured,
                         double *sensitivity)
{
    const int rules = IT2_RULE_PARAMETERS * parameters->ruleCount;
    const int columns = rules + count;
    double core[COLUMNS] = { 0.0 }; /* derivatives of the core's output */
    double gradient[IT2_RULE_PARAMETERS * IT2_MAX_RULES];
    struct it2_partials f;
    struct walker walker;
    struct pair *pairs = malloc((size_t)(count > 0 ? count : 1) * sizeof *pairs);
    struct columns *d = malloc(sizeof *d);
    size_t k = 0;

    if (!pairs || !d || count > CHAIN_MAX_KNOBS)
        goto end;
    *d = (struct columns){ .count = columns };
    const struct start start = begin(&walker, parameters, record->voltage[0]);
    it2_gradient(&walker.chain.core, walker.state.core.y, start.input, gradient, &f);
    /* at rest y = F(y, x, p): dy = (dF/dp dp + dF/dx dx) / (1 - dF/dy); elsewhere the reading is given */
    const double follows = start.at_rest ? 1.0 / (1.0 - f.dy) : 0.0;
    for (int i = 0; i < rules; i++)
        core[i] = follows * gradient[i];
    for (int j = 0; j < count; j++) {
        const struct beginning by =
            begin_pair(&pairs[j], parameters, record->voltage[0], walker.state.core.y, &knobs[j]);
        core[rules + j] = start.at_rest ? follows * f.dx * by.input : by.core;
    }
    begin_columns(d, &walker.chain, core);
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
