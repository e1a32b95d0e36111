#include "chain_sensitivity.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { RULE_COLUMNS = IT2_RULE_PARAMETERS * IT2_MAX_RULES, COLUMNS = RULE_COLUMNS + CHAIN_MAX_KNOBS };

/* A chain and where it is. */
struct walker {
    struct chain chain;
    struct chain_state state;
};

/* A parameter that is fitted. */
struct knob {
    struct chain_parameters d_parameters; /* 1 where it is */
    struct chain d;                       /* what it changes of the constants, */
    bool before;                          /* of which some are those of stages before the core, */
    struct chain_state d_state;           /* and of the states at rest */
    int column;                           /* before the core; 0 where it acts there by the rest only */
};

/* Derivatives of one side's states, for stage after stage as its tangent has them: a row for each number of
 * the state, a column for each direction. */
struct side {
    int first, end; /* among the active stages */
    int columns;
    double *states;
    struct stage_surroundings *d_around; /* of each column: the voltage at the actuator, behind the core */
};

/* Before the core all columns begin with the voltage at which the stage rests, and most have nothing else to
 * do with that side: so there is one column, number 0, for a core's input at rest that is 1 higher, and one
 * for each parameter that acts there by itself. Behind the core there is one for everything that is fitted. */
struct sensitivities {
    struct walker walker;
    struct side before, behind;
    int rules, count;
    double row[CHAIN_MAX_KNOBS + 1]; /* before the core, of what goes from stage to stage */
    double core[COLUMNS];            /* of the core's output */
    double resting[COLUMNS];         /* of the core's input at rest, of columns that act by it only */
    struct knob *knob;
    unsigned char acting[CHAIN_STAGE_COUNT][CHAIN_MAX_KNOBS]; /* knobs that act in each active stage */
    int acting_count[CHAIN_STAGE_COUNT];
};

/* A fit is of (10) itself: which range it holds for comes out in the end. */
static void begin(struct walker *walker, const struct chain_parameters *parameters)
{
    chain_prepare(&walker->chain, parameters);
    it2_prepare(&walker->chain.core, parameters->rule, parameters->ruleCount, IT2_EVERYWHERE);
    chain_reset(&walker->chain, &walker->state, parameters);
}

static struct stage_surroundings at(const struct chain_parameters *parameters,
                                    const struct chain_record *record, size_t k)
{
    const double time = (double)(record->first_tick + (int64_t)k) * parameters->sampleTime;

    return (struct stage_surroundings){ record->force[k], record->temperature[k], time, 0.0 };
}

size_t chain_predict(const struct chain_parameters *parameters, const struct chain_record *record,
                     double *measured, double *core_input, double *core_output)
{
    struct walker walker;
    const struct chain *chain = &walker.chain;

    begin(&walker, parameters);
    for (size_t k = 0; k < record->samples; k++) {
        const struct stage_surroundings around = at(parameters, record, k);
        const double x = chain_walk(chain, 0, chain->before, &walker.state, record->voltage[k], &around);
        const double y = it2_step(&chain->core, &walker.state.core, x);
        const struct stage_surroundings driven = driven_by(&around, x);
        measured[k] = chain_walk(chain, chain->before, chain->all, &walker.state, y, &driven);
        if (core_input) {
            core_input[k] = x;
            core_output[k] = y;
        }
        if (!isfinite(measured[k]))
            return k;
    }
    return record->samples;
}

/* --- where it begins --------------------------------------------------------------------------- */

static bool any(const void *bytes, size_t size)
{
    const unsigned char *byte = bytes;

    for (size_t i = 0; i < size; i++)
        if (byte[i])
            return true;
    return false;
}

/* What knob number j changes of constants and rest; returns the derivative of the core's output at rest. */
static double begin_knob(struct sensitivities *s, int j, const struct chain_parameters *parameters,
                         size_t place)
{
    const struct chain *chain = &s->walker.chain;
    struct knob *knob = &s->knob[j];

    memset(knob, 0, sizeof *knob);
    *(double *)((char *)&knob->d_parameters + place) = 1.0;
    chain_prepare_tangent(chain, &knob->d, parameters, &knob->d_parameters);
    for (int i = 0; i < chain->all; i++) {
        const struct chain_place *stage = chain_active(chain, i);
        if (!any(chain_constants_of(&knob->d, stage), stage->constants_size))
            continue;
        s->acting[i][s->acting_count[i]++] = (unsigned char)j;
        knob->before |= i < chain->before;
    }
    return chain_rest_tangent(chain, chain->before, chain->behind, &knob->d, parameters->initialDisplacement,
                              parameters, &knob->d_state, knob->d_parameters.initialDisplacement,
                              &knob->d_parameters);
}

/* Does it change the states before the core by more than the core's input at rest? */
static bool acts_before(const struct knob *knob, const struct chain *chain, double input,
                        const struct chain_parameters *parameters)
{
    struct chain_state d = { .core = { 0.0 } };
    const double by_itself =
        chain_rest_tangent(chain, 0, chain->before, &knob->d, input, parameters, &d, 0.0, &knob->d_parameters);

    return knob->before || by_itself != 0.0 || any(&d, sizeof d);
}

/* Puts the derivatives of a side's states into a column. */
static void put(struct side *side, const struct chain *chain, const struct chain_state *d, int column)
{
    double *to = side->states + column;

    for (int i = side->first; i < side->end; i++) {
        const struct chain_place *place = chain_active(chain, i);
        const double *from = (const double *)((const char *)d + place->state);
        for (size_t k = 0; k < place->state_size / sizeof *from; k++, to += side->columns)
            *to = from[k];
    }
}

static bool allocate(struct side *side, const struct chain *chain, int columns)
{
    size_t numbers = 1;

    side->columns = columns;
    for (int i = side->first; i < side->end; i++)
        numbers += chain_active(chain, i)->state_size / sizeof(double);
    side->states = calloc(numbers * (size_t)columns, sizeof(double));
    side->d_around = calloc((size_t)columns, sizeof *side->d_around);
    return side->states && side->d_around;
}

static bool begin_sensitivities(struct sensitivities *s, const struct chain_parameters *parameters,
                                const size_t *places)
{
    const struct chain *chain = &s->walker.chain;
    const struct chain_parameters nothing = { .sampleTime = 0.0 };
    double gradient[RULE_COLUMNS];
    struct it2_partials f;
    int columns = 1;

    begin(&s->walker, parameters);
    const double y = s->walker.state.core.y, input = it2_solve(&chain->core, y, y);
    it2_gradient(&chain->core, y, input, gradient, &f);
    for (int i = 0; i < s->rules; i++)
        s->resting[i] = -gradient[i] / f.dx;
    for (int j = 0; j < s->count; j++) {
        struct knob *knob = &s->knob[j];
        s->core[s->rules + j] = begin_knob(s, j, parameters, places[j]);
        s->resting[s->rules + j] = s->core[s->rules + j] * (1.0 - f.dy) / f.dx;
        knob->column = acts_before(knob, chain, input, parameters) ? columns++ : 0;
    }
    s->before.end = s->behind.first = chain->before;
    s->behind.end = chain->all;
    if (!allocate(&s->before, chain, columns) || !allocate(&s->behind, chain, s->rules + s->count))
        return false;
    struct chain *none = calloc(1, sizeof *none);
    struct chain_state d = { .core = { 0.0 } };
    if (!none)
        return false;
    chain_rest_tangent(chain, 0, chain->before, none, input, parameters, &d, 1.0, &nothing);
    free(none);
    put(&s->before, chain, &d, 0);
    for (int j = 0; j < s->count; j++) {
        struct knob *knob = &s->knob[j];
        put(&s->behind, chain, &knob->d_state, s->rules + j);
        if (!knob->column)
            continue;
        chain_rest_tangent(chain, 0, chain->before, &knob->d, input, parameters, &knob->d_state,
                           s->resting[s->rules + j], &knob->d_parameters);
        put(&s->before, chain, &knob->d_state, knob->column);
        s->resting[s->rules + j] = 0.0;
    }
    return true;
}

/* --- a tick ------------------------------------------------------------------------------------ */

/* Takes x and the row of derivatives over a side, and the states with them; returns the output. */
static double pass(struct sensitivities *s, struct side *side, double x, double *row,
                   const struct stage_surroundings *around)
{
    const struct chain *chain = &s->walker.chain;
    double *d_state = side->states;

    for (int i = side->first; i < side->end; i++) {
        const struct chain_place *place = chain_active(chain, i);
        const struct stage_analysis *analysis = chain_analysis(chain, i);
        const void *constants = chain_constants_of(chain, place);
        void *state = chain_state_of(&s->walker.state, place);
        if (analysis->tangent)
            analysis->tangent(constants, state, x, around, side->d_around, side->columns, d_state, row);
        for (int n = 0; n < s->acting_count[i]; n++) {
            const int j = s->acting[i][n];
            const struct knob *knob = &s->knob[j];
            const int column = side == &s->before ? knob->column : s->rules + j;
            row[column] += analysis->by_parameters(constants, chain_constants_of(&knob->d, place), state, x,
                                                   around, d_state + column, side->columns);
        }
        x = place->stage->step(constants, state, x, around);
        d_state += place->state_size / sizeof *d_state * (size_t)side->columns;
    }
    return x;
}

/* Returns the reading, or what is not finite where the derivatives are not. */
static double tick(struct sensitivities *s, double voltage, const struct stage_surroundings *around,
                   double *row)
{
    struct it2_state *core = &s->walker.state.core;
    const int columns = s->rules + s->count;
    double gradient[RULE_COLUMNS];
    double *before = s->row;
    struct it2_partials f;

    memset(before, 0, (size_t)s->before.columns * sizeof *before);
    const double x = pass(s, &s->before, voltage, before, around);
    core->y = it2_gradient(&s->walker.chain.core, core->y, x, gradient, &f);
    struct stage_surroundings *d = s->behind.d_around;
    for (int c = 0; c < columns; c++)
        d[c].voltage = before[0] * s->resting[c];
    for (int j = 0; j < s->count; j++)
        if (s->knob[j].column)
            d[s->rules + j].voltage += before[s->knob[j].column];
    for (int c = 0; c < columns; c++)
        s->core[c] = f.dy * s->core[c] + f.dx * d[c].voltage;
    for (int i = 0; i < s->rules; i++)
        s->core[i] += gradient[i];
    memcpy(row, s->core, (size_t)columns * sizeof *row);
    const struct stage_surroundings driven = driven_by(around, x);
    const double measured = pass(s, &s->behind, core->y, row, &driven);
    return isfinite(f.dy) ? measured : f.dy;
}

/* Is it (10) alone that is fitted, from a displacement of its own? */
static bool is_core_alone(const struct chain_parameters *parameters, const size_t *places, int count)
{
    struct walker walker;

    if (count != 1 || places[0] != offsetof(struct chain_parameters, initialDisplacement))
        return false;
    begin(&walker, parameters);
    return walker.chain.all == 0;
}

size_t chain_sensitivity(const struct chain_parameters *parameters, const struct chain_record *record,
                         bool by_rules, const size_t *places, int count, double *measured, double *sensitivity)
{
    if (by_rules && is_core_alone(parameters, places, count))
        return it2_free_run(parameters->rule, parameters->ruleCount, IT2_EVERYWHERE, record->voltage,
                            record->samples, parameters->initialDisplacement, measured, sensitivity);
    struct sensitivities *s = calloc(1, sizeof *s);
    size_t k = 0;

    if (!s || count > CHAIN_MAX_KNOBS)
        goto end;
    s->rules = by_rules ? IT2_RULE_PARAMETERS * parameters->ruleCount : 0;
    s->count = count;
    s->knob = calloc((size_t)count + 1, sizeof *s->knob);
    if (!s->knob || !begin_sensitivities(s, parameters, places))
        goto end;
    for (; k < record->samples; k++) {
        const struct stage_surroundings around = at(parameters, record, k);
        measured[k] = tick(s, record->voltage[k], &around, sensitivity + k * (size_t)(s->rules + count));
        if (!isfinite(measured[k]))
            break;
    }
end:
    if (s) {
        free(s->knob);
        free(s->before.states);
        free(s->before.d_around);
        free(s->behind.states);
        free(s->behind.d_around);
    }
    free(s);
    return k;
}
