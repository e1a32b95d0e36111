/* it2hys.c: generated from fmu_src by python -m it2hys.fmu.amalgamation. */
#if !defined _WIN32 && !defined _GNU_SOURCE
#define _GNU_SOURCE /* dladdr */
#endif
#include "it2hys.h"

#include <ctype.h>
#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>


/* --- chain.c --- */

/* Values of a range are the same if no more than this share of it is between them, or last digits. */
#define SAME REAL(1e-10)
#define LAST_DIGITS (64 * REAL_EPSILON)

/* --- the list ---------------------------------------------------------------------------------- */

/* clang-format off */
#define PLACE(name, side, memory, at, beside, size) \
    { &name##_stage, CHAIN_##side, CHAIN_##memory, offsetof(struct chain, name), sizeof(struct name), at, \
      beside, size },
#define PLACE_OF_STATE(name, side, memory, beside) \
    PLACE(name, side, memory, offsetof(struct chain_state, name), beside, sizeof(struct name##_state))
#define PLACE_NONE(name, NAME, side) PLACE(name, side, NONE, 0, 0, 0)
#define PLACE_AIMED(name, NAME, side) \
    PLACE_OF_STATE(name, side, AIMED, \
                   offsetof(struct chain_state, reached) + offsetof(struct chain_reached, name))
#define PLACE_SHORT(name, NAME, side) PLACE_OF_STATE(name, side, SHORT, 0)
#define PLACE_LONG(name, NAME, side) PLACE_OF_STATE(name, side, LONG, 0)
#define PLACE_LONGEST(name, NAME, side) PLACE_OF_STATE(name, side, LONGEST, 0)

const struct chain_place CHAIN_PLACES[CHAIN_STAGE_COUNT] = {
    CHAIN_STAGES(PLACE_NONE, PLACE_AIMED, PLACE_SHORT, PLACE_LONG, PLACE_LONGEST)
};
/* clang-format on */

/* --- set up ------------------------------------------------------------------------------------ */

/* What rings reads beyond where it comes to rest, by up to the height of a step. */
static struct it2_range beyond(struct it2_range range)
{
    const real step = range.maximum - range.minimum;

    return (struct it2_range){ range.minimum - step, range.maximum + step };
}

/* A stage that limits, and has a state: what it lets through is where the plant goes. */
static bool is_followed(const struct chain_place *place)
{
    return place->stage->limits && place->memory != CHAIN_NONE;
}

static void activate(struct chain *chain, int i, const struct chain_parameters *p)
{
    const struct chain_place *place = &CHAIN_PLACES[i];
    void *constants = (char *)chain + place->constants;

    chain->active[chain->all++] = place;
    chain->before += place->side == CHAIN_BEFORE;
    chain->behind += place->side != CHAIN_READING;
    if (place->side == CHAIN_READING)
        chain->reading |= 1u << i;
    else
        chain->effects |= 1u << i;
    if (place->stage->limits && place->side == CHAIN_BEFORE) {
        chain->followed[chain->limiting_all] = is_followed(place);
        chain->limiting[chain->limiting_all++] = place;
    } else if (place->stage->inverse && place->side != CHAIN_READING) {
        if (place->memory == CHAIN_LONG)
            chain->remembering[chain->remembering_all++] = (unsigned char)chain->solved_all;
        chain->solved[chain->solved_all++] = place;
        chain->solved_before += place->side == CHAIN_BEFORE;
    }
    place->stage->prepare(constants, p);
    if (place->side == CHAIN_BEHIND && place->memory == CHAIN_AIMED)
        chain->reference = beyond(chain->displacement);
    if (place->stage->latency)
        chain->latency += place->stage->latency(constants);
    const size_t end = place->state + (place->stage->used ? place->stage->used(constants) : place->state_size);
    if (end > chain->walked)
        chain->walked = end;
    if (end > chain->retraced && place->stage->inverse)
        chain->retraced = end;
}

void chain_prepare(struct chain *chain, const struct chain_parameters *p)
{
    const struct it2_range range = { p->displacementMin, p->displacementMax };

    memset(chain, 0, sizeof *chain);
    chain->displacement = chain->reference = range;
    chain->voltage = (struct it2_range){ p->voltageMin, p->voltageMax };
    it2_prepare(&chain->core, p->rule, p->ruleCount, range);
    chain->walked = chain->retraced = sizeof(struct it2_state);
    for (int i = 0; i < CHAIN_STAGE_COUNT; i++)
        if (CHAIN_PLACES[i].stage->is_on(p))
            activate(chain, i, p);
    const size_t reached = offsetof(struct chain_state, reached) + sizeof(struct chain_reached);
    if (chain->effects && chain->retraced < reached)
        chain->retraced = reached;
}

void chain_pass_by_idle(struct chain *chain, const struct chain_parameters *p)
{
    for (int i = 0; i < chain->behind; i++) {
        const struct chain_place *place = chain_active(chain, i);
        if (!place->stage->is_idle || !place->stage->is_idle(p))
            return;
    }
    chain->effects = 0;
}

/* The plant is where it was aimed at. */
static void arrive(struct chain_state *state)
{
    copy_words(&state->reached, state, sizeof state->reached);
}

/* From the output at rest of a stage to its input, back over those from number `end` - 1 to `first`. */
static real rest(const struct chain *chain, int first, int end, struct chain_state *state, real y,
                 const struct chain_parameters *parameters)
{
    for (int i = end - 1; i >= first; i--) {
        const struct chain_place *place = chain_active(chain, i);
        y = chain_rest_of(place, chain_constants_of(chain, place), chain_state_of(state, place), y, parameters);
    }
    return y;
}

void chain_reset(const struct chain *chain, struct chain_state *state,
                 const struct chain_parameters *parameters)
{
    *state = (struct chain_state){ .core = { 0 } };
    const real y =
        rest(chain, chain->before, chain->behind, state, parameters->initialDisplacement, parameters);
    it2_reset(&state->core, y);
    if (!chain->effects)
        return;
    rest(chain, 0, chain->before, state, it2_solve(&chain->core, y, y), parameters);
    arrive(state);
}

/* --- forwards ---------------------------------------------------------------------------------- */

real chain_walk(const struct chain *chain, int first, int end, struct chain_state *state, real x,
                const struct stage_surroundings *around)
{
    for (int i = first; i < end; i++) {
        const struct chain_place *place = chain_active(chain, i);
        x = place->stage->step(chain_constants_of(chain, place), chain_state_of(state, place), x, around);
    }
    return x;
}

real chain_step_effects(const struct chain *chain, struct chain_state *state, real voltage,
                        const struct chain_surroundings *around)
{
    struct stage_surroundings now = chain_around(around);

    now.voltage = chain_walk(chain, 0, chain->before, state, voltage, &now);
    const real y = it2_step(&chain->core, &state->core, now.voltage);
    return chain_walk(chain, chain->before, chain->behind, state, y, &now);
}

real chain_measure_effects(const struct chain *chain, real displacement, real time)
{
    const struct stage_surroundings around = { .time = time };

    return chain_walk(chain, chain->behind, chain->all, NULL, displacement, &around);
}

/* --- backwards --------------------------------------------------------------------------------- */

static real within_reach(const struct chain *chain, real displacement)
{
    return clamp(displacement, chain->reference.minimum, chain->reference.maximum);
}

static real within_voltages(const struct chain *chain, real x)
{
    return clamp(x, chain->voltage.minimum, chain->voltage.maximum);
}

static bool is_near(real a, real b, struct it2_range range)
{
    const real low = range.minimum, high = range.maximum;

    return real_fabs(a - b) <= SAME * (high - low) + LAST_DIGITS * real_fmax(real_fabs(low), real_fabs(high));
}

static inline bool other_voltage(const struct chain *chain, real a, real b)
{
    return a != b && !is_near(a, b, chain->voltage);
}

bool chain_is_astray(const struct chain_state *state)
{
    const real *aimed = &state->core.y, *reached = &state->reached.core.y;

    for (size_t i = 0; i < sizeof state->reached / sizeof *reached; i++)
        if (reached[i] != aimed[i])
            return true;
    return false;
}

static bool is_back(const struct chain *chain, const struct chain_state *state)
{
    if (!is_near(state->reached.core.y, state->core.y, chain->displacement))
        return false;
    for (int i = 0; i < chain->behind; i++) {
        const struct chain_place *place = chain_active(chain, i);
        const real *aimed = (const real *)((const char *)state + place->state);
        const real *reached = (const real *)((const char *)state + place->reached);
        const struct it2_range range = place->side == CHAIN_BEFORE ? chain->voltage : chain->displacement;
        for (size_t k = 0; place->memory == CHAIN_AIMED && k < place->state_size / sizeof *aimed; k++)
            if (!is_near(reached[k], aimed[k], range))
                return false;
    }
    return true;
}

/* Takes the plant's way on from `x` over the stages from number `first` to before `end`. */
static real follow(const struct chain *chain, int first, int end, struct chain_state *state, real x,
                   const struct stage_surroundings *around)
{
    for (int i = first; i < end; i++) {
        const struct chain_place *place = chain_active(chain, i);
        void *own = (char *)state + (place->memory == CHAIN_AIMED ? place->reached : place->state);
        if (place->stage->inverse && !is_followed(place))
            x = place->stage->step(chain_constants_of(chain, place), own, x, around);
    }
    return x;
}

/* The plant's way from what its amplifier lets through; returns whether it is where it was aimed at. */
static bool follow_plant(const struct chain *chain, struct chain_state *state, real x,
                         const struct stage_surroundings *around)
{
    x = follow(chain, 0, chain->before, state, x, around);
    const real y = it2_step(&chain->core, &state->reached.core, x);
    const struct stage_surroundings driven = driven_by(around, x);
    follow(chain, chain->before, chain->behind, state, y, &driven);
    if (!is_back(chain, state))
        return false;
    arrive(state);
    return true;
}

/* The plant's way where nothing is cut off: `input` is what each of `solved` was aimed to get. */
static void follow_aim(const struct chain *chain, struct chain_state *state, const real input[],
                       const struct stage_surroundings *around)
{
    for (int i = 0; i < chain->remembering_all; i++) {
        const int k = chain->remembering[i];
        const struct chain_place *place = chain->solved[k];
        place->stage->step(chain_constants_of(chain, place), chain_state_of(state, place), input[k], around);
    }
    arrive(state);
}

/* Back over number `end` - 1 to `first` of `solved`; notes what each is to get. */
static real solve(const struct chain *chain, int first, int end, struct chain_state *state, real y,
                  const struct stage_surroundings *around, real input[])
{
    for (int i = end - 1; i >= first; i--) {
        const struct chain_place *place = chain->solved[i];
        y = place->stage->inverse(chain_constants_of(chain, place), chain_state_of(state, place), y, around);
        input[i] = y;
    }
    return y;
}

/* The nearest voltage to `wanted` that may be given. `*passed` is what the amplifier makes of it: something
 * else only while the amplifier, at rest at the start, is farther out of the range than it can come back in a
 * tick. */
static real within_limits(const struct chain *chain, struct chain_state *state, real wanted, real *passed,
                          unsigned *limits)
{
    real x = wanted, allowed = wanted;
    bool followed = false;

    for (int i = chain->limiting_all - 1; i >= 0; i--) {
        const struct chain_place *place = chain->limiting[i];
        allowed = chain->followed[i] ? within_voltages(chain, x) : x;
        if (other_voltage(chain, allowed, x))
            *limits |= CHAIN_VOLTAGE_RANGE;
        x = place->stage->inverse(chain_constants_of(chain, place), chain_state_of(state, place), allowed,
                                  NULL);
        if (other_voltage(chain, x, allowed))
            *limits |= CHAIN_AMPLIFIER;
        followed |= chain->followed[i];
    }
    const real voltage = within_voltages(chain, x);
    if (other_voltage(chain, voltage, x))
        *limits |= CHAIN_VOLTAGE_RANGE;
    *passed = followed ? x : voltage;
    return voltage;
}

static real inverse_with_effects(const struct chain *chain, struct chain_state *state, real displacement,
                                 const struct chain_surroundings *around, unsigned *limits)
{
    const bool astray = chain_is_astray(state);
    /* what acts behind the core does so when the voltage arrives */
    struct stage_surroundings now = chain_around(around), later = now;
    real input[CHAIN_STAGE_COUNT] = { 0 };
    real passed;
    unsigned cut = 0;

    later.time += chain->latency;
    const real aim = solve(chain, chain->solved_before, chain->solved_all, state, displacement, &later, input);
    const real x = it2_inverse(&chain->core, &state->core, aim);
    const real wanted = solve(chain, 0, chain->solved_before, state, x, &now, input);
    const real voltage = within_limits(chain, state, wanted, &passed, &cut);
    *limits |= cut;
    now.voltage = x;
    if (!astray && !cut)
        follow_aim(chain, state, input, &now);
    else if (!follow_plant(chain, state, passed, &now))
        *limits |= CHAIN_RETURNING;
    return voltage;
}

/* Without effects; goes on from what the plant reaches. */
static real inverse_of_core(const struct chain *chain, struct chain_state *state, real displacement,
                            unsigned *limits)
{
    const real before = state->core.y;
    const real wanted = it2_inverse(&chain->core, &state->core, displacement);
    const real voltage = within_voltages(chain, wanted);

    if (voltage == wanted)
        return voltage;
    it2_reset(&state->core, before);
    it2_step(&chain->core, &state->core, voltage);
    if (other_voltage(chain, voltage, wanted))
        *limits |= CHAIN_VOLTAGE_RANGE;
    return voltage;
}

real chain_inverse(const struct chain *chain, struct chain_state *state, real displacement,
                   const struct chain_surroundings *around, unsigned *limits)
{
    const real aim = within_reach(chain, displacement);

    *limits = aim != displacement ? CHAIN_REFERENCE_RANGE : 0u;
    return chain->effects ? inverse_with_effects(chain, state, aim, around, limits)
                          : inverse_of_core(chain, state, aim, limits);
}

/* --- at rest ----------------------------------------------------------------------------------- */

/* The stages with a long memory hold, as they are; the others follow, to where they rest. */
real chain_hold(const struct chain *chain, const struct chain_state *state)
{
    real x = it2_solve(&chain->core, state->core.y, state->core.y);
    struct chain_state rested;

    for (int i = chain->before - 1; i >= 0; i--) {
        const struct chain_place *place = chain_active(chain, i);
        const void *constants = chain_constants_of(chain, place);
        if (place->memory == CHAIN_LONG)
            x = place->stage->inverse(constants, chain_state_of((struct chain_state *)state, place), x, NULL);
        else if (place->memory != CHAIN_SHORT && place->stage->rest)
            x = place->stage->rest(constants, chain_state_of(&rested, place), x, NULL);
    }
    return x;
}

real chain_equilibrium(const struct chain *chain, const struct chain_state *state)
{
    real x = chain_hold(chain, state);

    if (!isfinite(x)) /* nothing holds it there */
        return x;
    for (int i = chain->limiting_all - 1; i >= 0; i--) {
        const struct chain_place *place = chain->limiting[i];
        if (!is_followed(place))
            x = place->stage->inverse(chain_constants_of(chain, place), NULL, x, NULL);
    }
    return within_voltages(chain, x);
}

/* --- chain_check.c --- */

/* What makes a parameter set usable. */

/* How far beyond the range a run may begin, in lengths of the range: a stage is not farther away, and a
 * displacement in another unit is. */
#define FARTHEST_START 4

/* For parameters that have passed all other checks. */
static bool check_start(const struct chain_parameters *p, char *message, size_t size)
{
    const real reach = FARTHEST_START * (p->displacementMax - p->displacementMin);
    struct chain chain;
    struct chain_state state;

    chain_prepare(&chain, p);
    chain_reset(&chain, &state, p);
    if (state.core.y >= p->displacementMin - reach && state.core.y <= p->displacementMax + reach)
        return true;
    return refuse(message, size,
                  "initialDisplacement is %g m: the run would begin more than %g times the length of "
                  "displacementMin..displacementMax, %g to %g m, outside it; set it to where the stage is "
                  "(is it in another unit?)",
                  (double)p->initialDisplacement, (double)FARTHEST_START, (double)p->displacementMin,
                  (double)p->displacementMax);
}

static bool check_stages(const struct chain_parameters *p, char *message, size_t size)
{
    for (int i = 0; i < CHAIN_STAGE_COUNT; i++)
        if (CHAIN_ANALYSES[i]->check && !CHAIN_ANALYSES[i]->check(p, message, size))
            return false;
    return true;
}

bool chain_check(const struct chain_parameters *parameters, char *message, size_t size)
{
    const struct it2_range range = { parameters->displacementMin, parameters->displacementMax };

    if (!(parameters->sampleTime > 0))
        return refuse(message, size, "sampleTime is %g s; it must be positive", (double)parameters->sampleTime);
    if (!(parameters->voltageMin < parameters->voltageMax))
        return refuse(message, size, "voltageMin, %g V, must be below voltageMax, %g V",
                      (double)parameters->voltageMin, (double)parameters->voltageMax);
    return it2_check(parameters->rule, parameters->ruleCount, range, message, size) &&
           check_stages(parameters, message, size) && check_start(parameters, message, size);
}

/* --- chain_tangent.c --- */

/* Directional derivatives: the same walks as those of chain.c, over the stages' tangents. */

#define ANALYSIS(name, NAME, side) &name##_analysis,
const struct stage_analysis *const CHAIN_ANALYSES[CHAIN_STAGE_COUNT] = { CHAIN_EVERY_STAGE(ANALYSIS) };

/* A value and its derivative. */
struct both {
    real value;
    real d;
};

/* Copies what one stage is about to advance, at `at` of a state; returns where that is. A whole state is long,
 * and little of it is in use. */
static void *copied(struct chain_state *copy, const struct chain_state *state, const struct chain_place *place,
                    size_t at)
{
    copy_words((char *)copy + at, (const char *)state + at, place->state_size);
    return (char *)copy + at;
}

static real stage_tangent(const struct chain *chain, int i, const void *state, real x, void *d_state, real d_x,
                          const struct stage_surroundings *around, const struct stage_surroundings *d_around)
{
    const struct stage_analysis *analysis = chain_analysis(chain, i);

    if (analysis->tangent)
        analysis->tangent(chain_constants_of(chain, chain_active(chain, i)), state, x, around, d_around, 1,
                          d_state, &d_x);
    return d_x;
}

/* Takes x on over the stages from number `first` to before `end`; advances `d`. */
static struct both walk_tangent(const struct chain *chain, int first, int end, const struct chain_state *state,
                                struct both x, const struct stage_surroundings *around, struct chain_state *d,
                                const struct stage_surroundings *d_around)
{
    struct chain_state copy;

    for (int i = first; i < end; i++) {
        const struct chain_place *place = chain_active(chain, i);
        void *own = copied(&copy, state, place, place->state);
        x.d = stage_tangent(chain, i, own, x.value, chain_state_of(d, place), x.d, around, d_around);
        x.value = place->stage->step(chain_constants_of(chain, place), own, x.value, around);
    }
    return x;
}

static real core_tangent(const struct chain *chain, const struct it2_state *state, real x, struct it2_state *d,
                         real d_x)
{
    const struct it2_partials f = it2_partials(&chain->core, state->y, x);

    d->y = f.dy * d->y + f.dx * d_x;
    return d->y;
}

struct chain_point chain_step_tangent(const struct chain *chain, const struct chain_state *state, real voltage,
                                      const struct chain_surroundings *around, struct chain_state d_state,
                                      real d_voltage, const struct chain_surroundings *d_around)
{
    struct chain_point d = { .state = d_state };
    struct stage_surroundings now = chain_around(around), d_now = chain_around(d_around);
    struct both x = { voltage, d_voltage };

    x = walk_tangent(chain, 0, chain->before, state, x, &now, &d.state, &d_now);
    now.voltage = x.value;
    d_now.voltage = x.d;
    x.d = core_tangent(chain, &state->core, x.value, &d.state.core, x.d);
    x.value = it2_evaluate(&chain->core, state->core.y, x.value);
    x = walk_tangent(chain, chain->before, chain->behind, state, x, &now, &d.state, &d_now);
    d.output = x.d;
    return d;
}

/* --- inverse ----------------------------------------------------------------------------------- */

/* From y = F(y_previous, x): dx = (dy - dF/dy_previous dy_previous) / (dF/dx). */
static real core_inverse_tangent(const struct chain *chain, const struct it2_state *state, real x,
                                 struct it2_state *d, real d_y)
{
    const struct it2_partials f = it2_partials(&chain->core, state->y, x);
    const real d_x = (d_y - f.dy * d->y) / f.dx;

    d->y = d_y;
    return d_x;
}

/* Of the nearest value to x within limits that may move, too. */
static struct both within(struct it2_range limits, struct both x, real d_minimum, real d_maximum)
{
    const real d = x.value < limits.minimum ? d_minimum : x.value > limits.maximum ? d_maximum : x.d;

    return (struct both){ clamp(x.value, limits.minimum, limits.maximum), d };
}

/* Back over the stages that do not limit; as solve of chain.c. */
static struct both solve_tangent(const struct chain *chain, int first, int end, const struct chain_state *state,
                                 struct both y, const struct stage_surroundings *around, struct chain_state *d,
                                 const struct stage_surroundings *d_around, struct both input[])
{
    struct chain_state copy;

    for (int i = end - 1; i >= first; i--) {
        const struct chain_place *place = chain_active(chain, i);
        const void *constants = chain_constants_of(chain, place);
        const void *own = chain_state_of((struct chain_state *)state, place);
        if (place->stage->inverse && !place->stage->limits) {
            void *advanced = copied(&copy, state, place, place->state);
            y.value = place->stage->inverse(constants, advanced, y.value, around);
            y.d = chain_analysis(chain, i)->inverse_tangent(constants, own, y.value, chain_state_of(d, place),
                                                            y.d, around, d_around);
        }
        input[i] = y;
    }
    return y;
}

/* As within_limits of chain.c: what the amplifier passes on. */
static struct both within_limits_tangent(const struct chain *chain, const struct chain_state *state,
                                         struct both x, struct chain_state *d)
{
    static const struct stage_surroundings none = { 0, 0, 0, 0 };
    struct chain_state copy;
    bool followed = false;

    for (int i = chain->before - 1; i >= 0; i--) {
        const struct chain_place *place = chain_active(chain, i);
        if (!place->stage->limits)
            continue;
        if (place->memory != CHAIN_NONE) {
            x = within(chain->voltage, x, 0, 0);
            followed = true;
        }
        void *own = copied(&copy, state, place, place->state);
        x.d = stage_tangent(chain, i, own, x.value, chain_state_of(d, place), x.d, &none, &none);
        x.value = place->stage->inverse(chain_constants_of(chain, place), own, x.value, &none);
    }
    return followed ? x : within(chain->voltage, x, 0, 0);
}

static void arrive_tangent(struct chain_state *d)
{
    memcpy(&d->reached, d, sizeof d->reached);
}

/* As follow of chain.c. */
static struct both follow_tangent(const struct chain *chain, int first, int end,
                                  const struct chain_state *state, struct both x,
                                  const struct stage_surroundings *around, struct chain_state *d,
                                  const struct stage_surroundings *d_around)
{
    struct chain_state copy;

    for (int i = first; i < end; i++) {
        const struct chain_place *place = chain_active(chain, i);
        const size_t at = place->memory == CHAIN_AIMED ? place->reached : place->state;
        void *own = copied(&copy, state, place, at);
        void *d_own = (char *)d + at;
        if (!place->stage->inverse || (place->stage->limits && place->memory != CHAIN_NONE))
            continue;
        x.d = stage_tangent(chain, i, own, x.value, d_own, x.d, around, d_around);
        x.value = place->stage->step(chain_constants_of(chain, place), own, x.value, around);
    }
    return x;
}

static void follow_plant_tangent(const struct chain *chain, const struct chain_state *state, struct both x,
                                 const struct stage_surroundings *around, struct chain_state *d,
                                 const struct stage_surroundings *d_around)
{
    x = follow_tangent(chain, 0, chain->before, state, x, around, d, d_around);
    const real y = it2_evaluate(&chain->core, state->reached.core.y, x.value);
    const real d_y = core_tangent(chain, &state->reached.core, x.value, &d->reached.core, x.d);
    const struct stage_surroundings driven = driven_by(around, x.value);
    const struct stage_surroundings d_driven = driven_by(d_around, x.d);
    follow_tangent(chain, chain->before, chain->behind, state, (struct both){ y, d_y }, &driven, d, &d_driven);
}

static void follow_aim_tangent(const struct chain *chain, const struct chain_state *state,
                               const struct both input[], const struct stage_surroundings *around,
                               struct chain_state *d, const struct stage_surroundings *d_around)
{
    for (int i = 0; i < chain->behind; i++) {
        const struct chain_place *place = chain_active(chain, i);
        const void *own = chain_state_of((struct chain_state *)state, place);
        if (place->memory == CHAIN_LONG)
            stage_tangent(chain, i, own, input[i].value, chain_state_of(d, place), input[i].d, around,
                          d_around);
    }
}

/* `after` is what chain_inverse leaves of `state`: there is the core's aim. */
static real inverse_with_effects_tangent(const struct chain *chain, const struct chain_state *state,
                                         const struct chain_state *after, unsigned limits, struct both y,
                                         const struct chain_surroundings *around, struct chain_state *d,
                                         const struct chain_surroundings *d_around)
{
    struct stage_surroundings now = chain_around(around), later = now, d_now = chain_around(d_around);
    struct both input[CHAIN_STAGE_COUNT] = { { 0, 0 } };

    later.time += chain->latency;
    const struct both aim =
        solve_tangent(chain, chain->before, chain->behind, state, y, &later, d, &d_now, input);
    struct both x = { it2_solve(&chain->core, state->core.y, after->core.y), 0 };
    x.d = core_inverse_tangent(chain, &state->core, x.value, &d->core, aim.d);
    const struct both wanted = solve_tangent(chain, 0, chain->before, state, x, &now, d, &d_now, input);
    const struct both passed = within_limits_tangent(chain, state, wanted, d);
    now.voltage = x.value;
    d_now.voltage = x.d;
    if (chain_is_astray(state) || limits & (CHAIN_AMPLIFIER | CHAIN_VOLTAGE_RANGE))
        follow_plant_tangent(chain, state, passed, &now, d, &d_now);
    else
        follow_aim_tangent(chain, state, input, &now, d, &d_now);
    if (!chain_is_astray(after))
        arrive_tangent(d);
    return within(chain->voltage, passed, 0, 0).d;
}

static real inverse_of_core_tangent(const struct chain *chain, const struct it2_state *state, real displacement,
                                    real d_displacement, struct it2_state *d)
{
    const real wanted = it2_solve(&chain->core, state->y, displacement);
    const real voltage = clamp(wanted, chain->voltage.minimum, chain->voltage.maximum);

    if (voltage == wanted)
        return core_inverse_tangent(chain, state, wanted, d, d_displacement);
    core_tangent(chain, state, voltage, d, 0);
    return 0;
}

struct chain_point chain_inverse_tangent(const struct chain *chain, const struct chain_state *state,
                                         real displacement, const struct chain_surroundings *around,
                                         struct chain_state d_state, real d_displacement,
                                         const struct chain_surroundings *d_around)
{
    struct chain_point d = { .state = d_state };
    struct it2_range reach = chain->reference;
    struct both y = { displacement, d_displacement };
    struct chain_state after;
    unsigned limits;

    memcpy(&after, state, chain->retraced);
    chain_inverse(chain, &after, displacement, around, &limits);
    if (limits & CHAIN_REFERENCE_RANGE)
        y = (struct both){ displacement < reach.minimum ? reach.minimum : reach.maximum, 0 };
    d.output = chain->effects
                   ? inverse_with_effects_tangent(chain, state, &after, limits, y, around, &d.state, d_around)
                   : inverse_of_core_tangent(chain, &state->core, y.value, y.d, &d.state.core);
    return d;
}

/* --- by parameters, at rest -------------------------------------------------------------------- */

void chain_prepare_tangent(const struct chain *chain, struct chain *d,
                           const struct chain_parameters *parameters,
                           const struct chain_parameters *d_parameters)
{
    memset(d, 0, sizeof *d);
    for (int i = 0; i < chain->all; i++) {
        const struct chain_place *place = chain_active(chain, i);
        const struct stage_analysis *analysis = chain_analysis(chain, i);
        void *d_constants = (char *)d + place->constants;
        if (analysis->prepare_tangent)
            analysis->prepare_tangent(d_constants, chain_constants_of(chain, place), parameters, d_parameters);
        else
            place->stage->prepare(d_constants, d_parameters);
    }
}

real chain_rest_tangent(const struct chain *chain, int first, int end, const struct chain *d_chain, real y,
                        const struct chain_parameters *parameters, struct chain_state *d, real d_y,
                        const struct chain_parameters *d_parameters)
{
    struct chain_state state;

    for (int i = end - 1; i >= first; i--) {
        const struct chain_place *place = chain_active(chain, i);
        const struct stage_analysis *analysis = chain_analysis(chain, i);
        const void *constants = chain_constants_of(chain, place);
        void *own = chain_state_of(&state, place), *d_own = chain_state_of(d, place);
        y = chain_rest_of(place, constants, own, y, parameters);
        d_y = analysis->rest_tangent ? analysis->rest_tangent(constants, chain_constants_of(d_chain, place),
                                                              own, d_own, y, d_y, parameters, d_parameters)
                                     : chain_rest_of(place, NULL, d_own, d_y, NULL);
    }
    return d_y;
}

/* From y = F(y, x, p): dx = (dy - dF/dy dy - dF/dp dp) / (dF/dx). */
static real core_rest_tangent(const struct chain *chain, real y, real d_y,
                              const struct chain_parameters *d_parameters)
{
    real gradient[IT2_RULE_PARAMETERS * IT2_MAX_RULES];
    struct it2_partials f;
    real d = d_y;

    it2_gradient(&chain->core, y, it2_solve(&chain->core, y, y), gradient, &f);
    d -= f.dy * d_y;
    d -= f.end * (y < chain->core.lower.y ? d_parameters->displacementMin : d_parameters->displacementMax);
    for (int l = 0; l < chain->core.rules; l++) {
        const real *by_rule = gradient + IT2_RULE_PARAMETERS * l;
        const struct it2_rule *rule = &d_parameters->rule[l];
        d -= by_rule[0] * rule->sigmaLower + by_rule[1] * rule->sigmaUpper + by_rule[2] * rule->centre +
             by_rule[3] * rule->q1 + by_rule[4] * rule->q2 + by_rule[5] * rule->q3;
    }
    return d / f.dx;
}

real chain_equilibrium_tangent(const struct chain *chain, const struct chain_state *state,
                               const struct chain_parameters *parameters,
                               const struct chain_parameters *d_parameters)
{
    static const struct stage_surroundings none = { 0, 0, 0, 0 };
    const real y = state->core.y;
    const real hold = it2_solve(&chain->core, y, y);
    struct chain d_chain;
    struct chain_state d;
    struct both x = { chain_hold(chain, state), 0 };

    chain_prepare_tangent(chain, &d_chain, parameters, d_parameters);
    x.d = chain_rest_tangent(chain, chain->before, chain->behind, &d_chain, parameters->initialDisplacement,
                             parameters, &d, d_parameters->initialDisplacement, d_parameters);
    x.d = core_rest_tangent(chain, y, x.d, d_parameters);
    x.d = chain_rest_tangent(chain, 0, chain->before, &d_chain, hold, parameters, &d, x.d, d_parameters);
    for (int i = chain->before - 1; i >= 0; i--) {
        const struct chain_place *place = chain_active(chain, i);
        const void *constants = chain_constants_of(chain, place);
        if (!place->stage->limits || place->memory != CHAIN_NONE)
            continue;
        x.d = stage_tangent(chain, i, NULL, x.value, NULL, x.d, &none, &none) +
              chain_analysis(chain, i)->by_parameters(constants, chain_constants_of(&d_chain, place), NULL,
                                                      x.value, &none, NULL, 0);
        x.value = place->stage->inverse(constants, NULL, x.value, &none);
    }
    return within(chain->voltage, x, d_parameters->voltageMin, d_parameters->voltageMax).d;
}

/* --- creep.c --- */

static bool creep_check(const struct chain_parameters *p, char *message, size_t size)
{
    real least = 1;

    if (p->creepCount < 0 || p->creepCount > CREEP_MAX)
        return refuse(message, size, "creepCount is %d; it must be 0 to %d", p->creepCount, CREEP_MAX);
    for (int i = 0; i < p->creepCount; i++) {
        const struct creep_element *element = &p->creep[i];
        if (!(element->timeConstant > 0))
            return refuse(message, size, "creep[%d].timeConstant is %g s; it must be positive", i + 1,
                          (double)element->timeConstant);
        least += real_fmin(element->gain, 0);
        if (!(least > 0))
            return refuse(message, size,
                          "1 plus the negative gains up to creep[%d].gain is %g; it must "
                          "be positive: creep could not be inverted",
                          i + 1, (double)least);
    }
    return true;
}

static bool creep_is_on(const struct chain_parameters *p)
{
    return p->creepCount > 0;
}

static bool creep_is_idle(const struct chain_parameters *p)
{
    for (int i = 0; i < p->creepCount; i++)
        if (p->creep[i].gain != 0)
            return false;
    return true;
}

static void creep_prepare(void *constants, const struct chain_parameters *p)
{
    struct creep *creep = constants;

    creep->first = 0;
    creep->count = p->creepCount;
    creep->zero = p->displacementZero;
    creep->slope = 1;
    for (int i = 0; i < creep->count; i++) {
        creep->gain[i] = p->creep[i].gain;
        creep->rate[i] = -real_expm1(-p->sampleTime / p->creep[i].timeConstant);
        creep->slope += creep->gain[i] * creep->rate[i];
    }
    creep->per_slope = 1 / creep->slope;
}

static size_t creep_used(const void *constants)
{
    const struct creep *creep = constants;

    return (size_t)creep->count * sizeof(real);
}

/* How far a term's state lies ahead of the input where initialCreep is 1. */
static real creep_kept(const struct chain_parameters *p, int i)
{
    return real_exp(-p->initialCreepAge / p->creep[i].timeConstant);
}

/* With states that lay initialCreep ahead of the input (by 0 after long rest), initialCreepAge ago. */
static real creep_rest(const void *constants, void *state, real y, const struct chain_parameters *p)
{
    const struct creep *creep = constants;
    struct creep_state *s = state;
    real sum = 1;

    y -= creep->zero;
    for (int i = 0; i < creep->count; i++) {
        sum += creep->gain[i];
        s->s[i] = p->initialCreep * creep_kept(p, i);
        y -= creep->gain[i] * s->s[i];
    }
    const real x = y / sum;
    for (int i = 0; i < creep->count; i++)
        s->s[i] += x;
    return creep->zero + x;
}

static real creep_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct creep *creep = constants;
    struct creep_state *s = state;
    const real above = x - creep->zero;
    real y = above;

    (void)around;
    for (int i = 0; i < creep->count; i++) {
        s->s[i] += creep->rate[i] * (above - s->s[i]);
        y += creep->gain[i] * s->s[i];
    }
    return creep->zero + y;
}

/* What of y above zero is left for the input, where the states are these. */
static real creep_solve(const struct creep *creep, const struct creep_state *s, real y)
{
    for (int i = 0; i < creep->count; i++)
        y -= creep->gain[i] * (s->s[i] - creep->rate[i] * s->s[i]);
    return y * creep->per_slope;
}

static real creep_inverse(const void *constants, void *state, real y, const struct stage_surroundings *around)
{
    const struct creep *creep = constants;

    (void)around;
    return creep->zero + creep_solve(creep, state, y - creep->zero);
}

static void creep_prepare_tangent(void *d_constants, const void *constants, const struct chain_parameters *p,
                                  const struct chain_parameters *d)
{
    const struct creep *creep = constants;
    struct creep *result = d_constants;

    result->zero = d->displacementZero;
    for (int i = creep->count - 1; i >= 0; i--) {
        const real ratio = p->sampleTime / p->creep[i].timeConstant;
        result->gain[i] = d->creep[i].gain;
        result->rate[i] = -ratio / p->creep[i].timeConstant * real_exp(-ratio) * d->creep[i].timeConstant;
        if (result->gain[i] == 0 && result->rate[i] == 0)
            continue;
        result->first = i;
        result->count = result->count ? result->count : i + 1;
    }
}

static real creep_rest_tangent(const void *constants, const void *d_constants, const void *state, void *d_state,
                               real x, real d_y, const struct chain_parameters *p,
                               const struct chain_parameters *d)
{
    const struct creep *creep = constants, *by = d_constants;
    struct creep_state *s = d_state;
    real sum = 1;

    (void)state;
    d_y -= by->zero;
    for (int i = 0; i < creep->count; i++) {
        const real kept = creep_kept(p, i), tau = p->creep[i].timeConstant;
        const real d_age = d->initialCreepAge - p->initialCreepAge / tau * d->creep[i].timeConstant;
        sum += creep->gain[i];
        s->s[i] = kept * (d->initialCreep - p->initialCreep * d_age / tau);
        d_y -= creep->gain[i] * s->s[i] + by->gain[i] * (x - creep->zero + p->initialCreep * kept);
    }
    const real d_x = d_y / sum;
    for (int i = 0; i < creep->count; i++)
        s->s[i] += d_x;
    return by->zero + d_x;
}

static void creep_tangent(const void *constants, const void *state, real x,
                          const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                          int count, real *restrict d_state, real *restrict row)
{
    const struct creep *creep = constants;
    real input[STAGE_CHUNK];

    (void)around, (void)state, (void)x, (void)d_around;
    for (int first = 0; first < count; first += STAGE_CHUNK) {
        const int n = count - first < STAGE_CHUNK ? count - first : STAGE_CHUNK;
        real *restrict output = row + first;
        memcpy(input, output, (size_t)n * sizeof *input);
        for (int i = 0; i < creep->count; i++) {
            real *restrict s = d_state + (ptrdiff_t)i * count + first;
            for (int c = 0; c < n; c++) {
                s[c] += creep->rate[i] * (input[c] - s[c]);
                output[c] += creep->gain[i] * s[c];
            }
        }
    }
}

static real creep_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                                const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct creep *creep = constants, *d = d_constants;
    const struct creep_state *s = state;
    const real above = x - creep->zero;
    real d_y = 0;

    (void)around;
    for (int i = d->first; i < d->count; i++) {
        const real moved = d->rate[i] * (above - s->s[i]);
        d_state[(ptrdiff_t)i * stride] += moved;
        d_y += creep->gain[i] * moved + d->gain[i] * (s->s[i] + creep->rate[i] * (above - s->s[i]));
    }
    for (int i = 0; i < creep->count && d->zero != 0; i++) {
        d_state[(ptrdiff_t)i * stride] -= creep->rate[i] * d->zero;
        d_y -= creep->gain[i] * creep->rate[i] * d->zero;
    }
    return d_y;
}

static real creep_inverse_tangent(const void *constants, const void *state, real x, void *d_state, real d_y,
                                  const struct stage_surroundings *around,
                                  const struct stage_surroundings *d_around)
{
    (void)around, (void)state, (void)x, (void)d_around;
    return creep_solve(constants, d_state, d_y); /* it is linear */
}

const struct stage creep_stage = {
    .is_on = creep_is_on,
    .is_idle = creep_is_idle,
    .prepare = creep_prepare,
    .rest = creep_rest,
    .step = creep_step,
    .used = creep_used,
    .inverse = creep_inverse,
};

const struct stage_analysis creep_analysis = {
    .check = creep_check,
    .prepare_tangent = creep_prepare_tangent,
    .rest_tangent = creep_rest_tangent,
    .tangent = creep_tangent,
    .by_parameters = creep_by_parameters,
    .inverse_tangent = creep_inverse_tangent,
};

/* --- delay.c --- */

/* Ticks: a time that is a whole number of them but for rounding is taken as whole. */
#define ROUNDING REAL(1e-9)

static bool delay_check(const struct chain_parameters *p, char *message, size_t size)
{
    if (!(p->delay.time >= 0))
        return refuse(message, size, "delay.time is %g s; it must not be negative", (double)p->delay.time);
    if (!(p->delay.time <= (DELAY_MAX_TICKS + ROUNDING) * p->sampleTime))
        return refuse(message, size,
                      "delay.time is %g s; at a sampleTime of %g s it must be at most %g s, "
                      "%d ticks",
                      (double)p->delay.time, (double)p->sampleTime, (double)(DELAY_MAX_TICKS * p->sampleTime),
                      DELAY_MAX_TICKS);
    return true;
}

static bool delay_is_on(const struct chain_parameters *p)
{
    return p->delay.time > 0;
}

static void delay_prepare(void *constants, const struct chain_parameters *p)
{
    const real ticks = p->delay.time / p->sampleTime;
    const real whole = real_floor(ticks + ROUNDING);
    const real fraction = ticks - whole;

    *(struct delay *)constants = (struct delay){ .ticks = (int)whole,
                                                 .fraction = fraction > ROUNDING ? fraction : 0,
                                                 .time = p->delay.time };
}

static real delay_latency(const void *constants)
{
    const struct delay *delay = constants;

    return delay->time;
}

static real delay_rest(const void *constants, void *state, real u, const struct chain_parameters *p)
{
    struct delay_state *s = state;

    (void)constants, (void)p;
    s->newest = 0;
    for (int i = 0; i < DELAY_MAX_TICKS; i++)
        s->u[i] = u;
    return u;
}

/* The number of voltages that are needed; one more than the output is made of, for its derivative. */
static int delay_needed(const struct delay *delay)
{
    return delay->ticks < DELAY_MAX_TICKS ? delay->ticks + 1 : DELAY_MAX_TICKS;
}

static size_t delay_used(const void *constants)
{
    return offsetof(struct delay_state, u) + (size_t)delay_needed(constants) * sizeof(real);
}

/* Where u_{k-1} is. A state that was not made here may say anything. */
static int delay_newest(const struct delay *delay, const struct delay_state *s)
{
    return s->newest >= 0 && s->newest < delay_needed(delay) ? (int)s->newest : 0;
}

/* Where, from there, the voltage of so many ticks before is. */
static int delay_before(const struct delay *delay, int newest, int ticks)
{
    const int place = newest + ticks, needed = delay_needed(delay);

    return place < needed ? place : place - needed;
}

static real delay_step(const void *constants, void *state, real u, const struct stage_surroundings *around)
{
    const struct delay *delay = constants;
    struct delay_state *s = state;
    const int newest = delay_newest(delay, s);
    const int oldest = delay_before(delay, newest, delay_needed(delay) - 1);
    real y = delay->ticks > 0 ? s->u[delay_before(delay, newest, delay->ticks - 1)] : u;

    (void)around;
    if (delay->fraction > 0)
        y += delay->fraction * (s->u[oldest] - y); /* of a whole tick more */
    s->u[oldest] = u;
    s->newest = (real)oldest;
    return y;
}

static void delay_prepare_tangent(void *d_constants, const void *constants, const struct chain_parameters *p,
                                  const struct chain_parameters *d)
{
    struct delay *result = d_constants;

    (void)constants;
    result->fraction = d->delay.time / p->sampleTime;
    result->time = d->delay.time;
}

static real delay_rest_tangent(const void *constants, const void *d_constants, const void *state, void *d_state,
                               real x, real d_y, const struct chain_parameters *p,
                               const struct chain_parameters *d)
{
    (void)state, (void)d_constants, (void)x, (void)d;
    return delay_rest(constants, d_state, d_y, p);
}

static void delay_tangent(const void *constants, const void *state, real x,
                          const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                          int count, real *restrict d_state, real *restrict row)
{
    const struct delay *delay = constants;
    const int newest = delay_newest(delay, state);
    const int oldest = delay_before(delay, newest, delay_needed(delay) - 1);
    /* the first row is that of `newest`, which nothing changes */
    real *const d_u = d_state + count;
    real *const d_oldest = d_u + (size_t)oldest * (size_t)count;
    const real *const d_here =
        delay->ticks > 0 ? d_u + (size_t)delay_before(delay, newest, delay->ticks - 1) * (size_t)count : row;

    (void)around, (void)x, (void)d_around;
    for (int c = 0; c < count; c++) {
        const real d_x = row[c], d_y = d_here[c];
        d_state[c] = 0;
        row[c] = delay->fraction > 0 ? d_y + delay->fraction * (d_oldest[c] - d_y) : d_y;
        d_oldest[c] = d_x;
    }
}

/* At a whole number of ticks the output has a corner; its derivative there is the mean of both sides. */
static real delay_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                                const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct delay *delay = constants, *d = d_constants;
    const struct delay_state *s = state;
    const int ticks = delay->ticks, newest = delay_newest(delay, s);
    const real here = ticks > 0 ? s->u[delay_before(delay, newest, ticks - 1)] : x;
    const real older = ticks < DELAY_MAX_TICKS ? s->u[delay_before(delay, newest, ticks)] : here;
    const real newer = ticks > 1 ? s->u[delay_before(delay, newest, ticks - 2)] : x;

    (void)around, (void)d_state, (void)stride;
    if (delay->fraction > 0)
        return d->fraction * (older - here);
    return d->fraction * (ticks < DELAY_MAX_TICKS ? REAL(0.5) * (older - newer) : here - newer);
}

const struct stage delay_stage = {
    .is_on = delay_is_on,
    .prepare = delay_prepare,
    .rest = delay_rest,
    .step = delay_step,
    .used = delay_used,
    .latency = delay_latency,
};

const struct stage_analysis delay_analysis = {
    .check = delay_check,
    .prepare_tangent = delay_prepare_tangent,
    .rest_tangent = delay_rest_tangent,
    .tangent = delay_tangent,
    .by_parameters = delay_by_parameters,
};

/* --- drift.c --- */

static bool drift_is_on(const struct chain_parameters *p)
{
    return p->drift.temperatureCoefficient != 0 || p->drift.rate != 0;
}

static void drift_prepare(void *constants, const struct chain_parameters *p)
{
    *(struct drift *)constants = (struct drift){ p->drift.temperatureCoefficient, p->drift.rate };
}

static real drift_offset(const struct drift *drift, const struct stage_surroundings *around)
{
    return drift->temperatureCoefficient * (around->temperature - DRIFT_REFERENCE_TEMPERATURE) +
           drift->rate * around->time;
}

static real drift_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    (void)state;
    return x + drift_offset(constants, around);
}

static real drift_inverse(const void *constants, void *state, real y, const struct stage_surroundings *around)
{
    (void)state;
    return y - drift_offset(constants, around);
}

static void drift_tangent(const void *constants, const void *state, real x,
                          const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                          int count, real *restrict d_state, real *restrict row)
{
    const struct drift *drift = constants;

    (void)around, (void)state, (void)x, (void)d_state;
    for (int c = 0; c < count; c++)
        row[c] += drift->temperatureCoefficient * d_around[c].temperature;
}

static real drift_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                                const struct stage_surroundings *around, real *d_state, int stride)
{
    (void)constants, (void)state, (void)x, (void)d_state, (void)stride;
    return drift_offset(d_constants, around);
}

static real drift_inverse_tangent(const void *constants, const void *state, real x, void *d_state, real d_y,
                                  const struct stage_surroundings *around,
                                  const struct stage_surroundings *d_around)
{
    const struct drift *drift = constants;

    (void)around, (void)state, (void)x, (void)d_state;
    return d_y - drift->temperatureCoefficient * d_around->temperature;
}

const struct stage drift_stage = {
    .is_on = drift_is_on,
    .prepare = drift_prepare,
    .step = drift_step,
    .inverse = drift_inverse,
};

const struct stage_analysis drift_analysis = {
    .tangent = drift_tangent,
    .by_parameters = drift_by_parameters,
    .inverse_tangent = drift_inverse_tangent,
};

/* --- hum.c --- */

/* --- sine.h --- */

/* sin of a phase that grows with the time, short enough to be inlined: for large ones, libm takes as long as half
 * of the other effects together.
 *
 * With the whole number n next to x / pi, sin x is sin(x - n pi), or the negative where n is odd. Three parts of
 * pi, the first two of 27 bits, so that n times them is exact; then r + r^3 p(r^2) with p of degree 7,
 * interpolated at Chebyshev nodes on |r| <= pi/2 (error 4e-19). Every compiler gets the same bits.
 * Measured error below 3e-16 (fmu_src/tests/test_sine.c). */

#if defined IT2HYS_SINGLE

static inline real sine(real x)
{
    return real_sin(x);
}

#else

/* Beyond this, n would have more than 26 bits. */
#define SINE_LARGEST 2e8

static inline real sine(real x)
{
    union {
        real value;
        uint64_t bits;
    } rounded = { x * 0.3183098861837907 + 6755399441055744.0 }; /* 1.5 * 2^52: n stands in the low bits */
    const real n = rounded.value - 6755399441055744.0;
    const real r = ((x - n * 3.141592651605606) - n * 1.9841871479187034e-09) - n * 1.1442377452219664e-17;
    const real u = r * r, u2 = u * u;
    const real low = (-0.16666666666666666 + 0.008333333333333316 * u) +
                     (-0.00019841269841254966 + 2.7557319219160833e-06 * u) * u2;
    const real high = (-2.505210761669045e-08 + 1.6058977292642743e-10 * u) +
                      (-7.643969663988074e-13 + 2.7314368769379893e-15 * u) * u2;
    const real value = r + r * u * (low + high * (u2 * u2));

    if (!(real_fabs(x) <= SINE_LARGEST))
        return real_sin(x);
    return rounded.bits % 2 ? -value : value;
}

#endif

static bool hum_check(const struct chain_parameters *p, char *message, size_t size)
{
    if (!(p->hum.amplitude >= 0))
        return refuse(message, size, "hum.amplitude is %g m; it must be positive, or 0 for none",
                      (double)p->hum.amplitude);
    if (p->hum.amplitude > 0 && !(p->hum.frequency > 0))
        return refuse(message, size, "hum.frequency is %g Hz; with a hum.amplitude it must be positive",
                      (double)p->hum.frequency);
    return true;
}

static bool hum_is_on(const struct chain_parameters *p)
{
    return p->hum.amplitude > 0;
}

static void hum_prepare(void *constants, const struct chain_parameters *p)
{
    *(struct hum *)constants = (struct hum){ p->hum.amplitude, p->hum.frequency, p->hum.phase };
}

static real hum_step(const void *constants, void *state, real y, const struct stage_surroundings *around)
{
    const struct hum *hum = constants;

    (void)state;
    return y + hum->amplitude * sine(TWO_PI * hum->frequency * around->time + hum->phase);
}

static real hum_by_parameters(const void *constants, const void *d_constants, const void *state, real y,
                              const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct hum *hum = constants, *d = d_constants;
    const real phase = TWO_PI * hum->frequency * around->time + hum->phase;
    const real d_phase = TWO_PI * d->frequency * around->time + d->phase;

    (void)state, (void)y, (void)d_state, (void)stride;
    return d->amplitude * sine(phase) + hum->amplitude * real_cos(phase) * d_phase;
}

const struct stage hum_stage = {
    .is_on = hum_is_on,
    .prepare = hum_prepare,
    .step = hum_step,
};

const struct stage_analysis hum_analysis = {
    .check = hum_check,
    .by_parameters = hum_by_parameters,
};

/* --- it2_check.c --- */

/* What makes a parameter set usable: 0 < s_l1 <= s_l2, invertible by (30), contracting. */

/* --- it2_membership.h --- */

/* The memberships (8), (9), (11), (12), evaluated for all rules at once. */

/* --- exponential.h --- */

/* exp of a non-positive argument, short enough to be inlined into a loop over rules.
 *
 * The argument comes multiplied by 64 / ln 2, which it2_prepare folds into its constants: then the
 * reduction is exact. exp(x) = 2^(n / 64) 2^(r / 64) with the integer n next to the scaled argument and
 * |r| <= 1/2; the first factor is from a table, with the part that its rounding left off, the second is
 * 1 + p(r) with p of degree 5, interpolated at Chebyshev nodes (error 1e-18). Without a call, the
 * exponentials of one step overlap, and every compiler gets the same bits.
 * Measured error below 1 unit in the last place (fmu_src/tests/test_exponential.c). */

#if defined IT2HYS_SINGLE

/* --- exponential_single.h --- */

/* exponential.h in single precision: exp(x) = 2^n e^(r ln 2) with the integer n next to the argument, which
 * comes multiplied by 1 / ln 2, and |r| <= 1/2; the second factor by its series to degree 7. */
#define EXP_SCALE 1.44269504f
#define EXP_UNDERFLOW (-126)

/* 1.5 * 2^23: a sum with it is rounded to an integer. */
#define EXP_ROUND 12582912

/* exp(x / EXP_SCALE) of two x in EXP_UNDERFLOW..0. */
static inline void exp_scaled_normal_pair(const real x[2], real result[2])
{
    for (int i = 0; i < 2; i++) {
        const real n = (x[i] + EXP_ROUND) - EXP_ROUND;
        const real r = (x[i] - n) * REAL(0.693147181);
        union {
            uint32_t bits;
            real value;
        } power = { ((uint32_t)(int32_t)n + 127) << 23 };
        real series = REAL(1.98412698e-4);

        series = series * r + REAL(1.38888889e-3);
        series = series * r + REAL(8.33333333e-3);
        series = series * r + REAL(4.16666667e-2);
        series = series * r + REAL(1.66666667e-1);
        series = series * r + REAL(0.5);
        series = series * r + 1;
        series = series * r + 1;
        result[i] = power.value * series;
    }
}

#else

#define EXP_STEPS 64 /* per factor of two */
#define EXP_SHIFT 46 /* from the low bits to the exponent, past log2(EXP_STEPS) of them */

/* Factor of the arguments, 64 / ln 2. */
#define EXP_SCALE 92.332482616893656877

/* Scaled arguments below this give 0: the smallest power of two that is still a normal number. */
#define EXP_UNDERFLOW (-1022.0 * EXP_STEPS)

/* --- exponential_table.h --- */

/* 2^(j/64), j = 0..63, for exponential.h: the bits of the nearest double less j * 2^46, so that adding
 * a multiple of 2^46 sets the exponent, and what rounding left off, relative to it. Two tables: an index
 * into one of pairs costs two instructions more. */
/* clang-format off */
static const uint64_t EXP_BITS[EXP_STEPS] = {
    0x3ff0000000000000u, 0x3fefec9a3e778061u, 0x3fefd9b0d3158574u, 0x3fefc74518759bc8u,
    0x3fefb5586cf9890fu, 0x3fefa3ec32d3d1a2u, 0x3fef9301d0125b51u, 0x3fef829aaea92de0u,
    0x3fef72b83c7d517bu, 0x3fef635beb6fcb75u, 0x3fef54873168b9aau, 0x3fef463b88628cd6u,
    0x3fef387a6e756238u, 0x3fef2b4565e27cddu, 0x3fef1e9df51fdee1u, 0x3fef1285a6e4030bu,
    0x3fef06fe0a31b715u, 0x3feefc08b26416ffu, 0x3feef1a7373aa9cbu, 0x3feee7db34e59ff7u,
    0x3feedea64c123422u, 0x3feed60a21f72e2au, 0x3feece086061892du, 0x3feec6a2b5c13cd0u,
    0x3feebfdad5362a27u, 0x3feeb9b2769d2ca7u, 0x3feeb42b569d4f82u, 0x3feeaf4736b527dau,
    0x3feeab07dd485429u, 0x3feea76f15ad2148u, 0x3feea47eb03a5585u, 0x3feea23882552225u,
    0x3feea09e667f3bcdu, 0x3fee9fb23c651a2fu, 0x3fee9f75e8ec5f74u, 0x3fee9feb564267c9u,
    0x3feea11473eb0187u, 0x3feea2f336cf4e62u, 0x3feea589994cce13u, 0x3feea8d99b4492edu,
    0x3feeace5422aa0dbu, 0x3feeb1ae99157736u, 0x3feeb737b0cdc5e5u, 0x3feebd829fde4e50u,
    0x3feec49182a3f090u, 0x3feecc667b5de565u, 0x3feed503b23e255du, 0x3feede6b5579fdbfu,
    0x3feee89f995ad3adu, 0x3feef3a2b84f15fbu, 0x3feeff76f2fb5e47u, 0x3fef0c1e904bc1d2u,
    0x3fef199bdd85529cu, 0x3fef27f12e57d14bu, 0x3fef3720dcef9069u, 0x3fef472d4a07897cu,
    0x3fef5818dcfba487u, 0x3fef69e603db3285u, 0x3fef7c97337b9b5fu, 0x3fef902ee78b3ff6u,
    0x3fefa4afa2a490dau, 0x3fefba1bee615a27u, 0x3fefd0765b6e4540u, 0x3fefe7c1819e90d8u,
};

static const double EXP_TAIL[EXP_STEPS] = {
    0x0.0p+0, -0x1.160139cd8dc5dp-56, 0x1.cd2523567f613p-55, 0x1.0f74e61e6c861p-57,
    0x1.79aa65d837b6dp-54, 0x1.ebe3d702f9cd1p-60, -0x1.556522a2fbd0ep-54, -0x1.1c923b9d5f416p-54,
    -0x1.01b15eaa59348p-55, 0x1.b898c3f1353bfp-55, 0x1.aecf73e3a2f60p-54, 0x1.a6f4144a6c38dp-55,
    0x1.68efde3a8a894p-54, 0x1.0472b981fe7f2p-55, 0x1.2f7e16d09ab31p-55, 0x1.b3782720c0ab4p-55,
    0x1.34d754db0abb6p-55, 0x1.fdd395dd3f84ap-55, -0x1.24aedcc4b5068p-54, -0x1.1d1e83e9436d2p-56,
    0x1.59f48a72a4c6dp-55, -0x1.8a78f4817895bp-58, 0x1.363ed60c2ac11p-59, 0x1.ecce1daa10379p-57,
    0x1.690cebb7aafb0p-56, -0x1.f94340071a38ep-55, -0x1.8dec6bd0f385fp-56, 0x1.3350518fdd78ep-54,
    0x1.063e1e21c5409p-54, 0x1.432e62b64c035p-54, -0x1.c33c53bef4da8p-55, -0x1.3cedd78565858p-54,
    -0x1.3b3efbf5e2228p-54, -0x1.367efb86da9eep-57, -0x1.81f647e5a3ecfp-56, -0x1.619321e55e68ap-55,
    -0x1.b32dcb94da51dp-56, 0x1.5ebe1abd66c55p-57, -0x1.369b6f13b3734p-54, -0x1.4d450d872576ep-54,
    0x1.db72fc1f0eab4p-55, 0x1.bf68359f35f44p-56, -0x1.da9b88b6c1e29p-58, -0x1.2434322f4f9aap-54,
    0x1.1affc2b91ce27p-56, -0x1.7c50422622263p-55, -0x1.1bbd1d3bcbb15p-54, 0x1.469846e735ab3p-55,
    0x1.c1a7792cb3387p-55, -0x1.5c3d956dcaebap-58, -0x1.8d6f438ad9334p-57, 0x1.4ffd70a5fddcdp-56,
    0x1.36eae30af0cb3p-56, 0x1.4e08fd10959acp-55, 0x1.76b2c6c921968p-57, -0x1.fad5d3ffffa6fp-55,
    0x1.4a385a63d07a7p-56, 0x1.e5a50d5c192acp-55, -0x1.2d52107b43e1fp-55, 0x1.4b604603a88d3p-56,
    -0x1.ff7128fd391f0p-55, 0x1.ec3bc41aa2008p-55, 0x1.a64a931d185eep-55, 0x1.7893b4d91cd9dp-56,
};
/* clang-format on */

/* 1.5 * 2^52: a sum with it is rounded to an integer, which stands in its low bits. */
#define EXP_ROUND 6755399441055744.0

/* 2^(r/64) - 1, and what the table's rounding left off: of doubles or of vectors of them. Short products
 * beside each other, not one long chain, and what is looked up comes last: a step waits for the slowest. */
#define EXP_REST(r, r2, tail) \
    ((tail) + (((r) * 0.010830424696249145 + (r2) * (5.864904955054418e-05 + (r) * 2.1173137155462066e-07)) + \
               (r2) * (r2) * (5.732857292414682e-10 + (r) * 1.2417852371895379e-12)))

/* exp(x / EXP_SCALE) of two x in EXP_UNDERFLOW..0. */
#if defined __GNUC__ && !defined EXP_ONE_BY_ONE

/* Two lanes beside each other, which compilers do not find by themselves in every surrounding; only the
 * table is read lane by lane. */
typedef double exp_lanes __attribute__((vector_size(16)));
typedef uint64_t exp_words __attribute__((vector_size(16)));

static inline void exp_scaled_normal_pair(const real x[2], real result[2])
{
    const exp_lanes scaled = { x[0], x[1] };
    const exp_lanes n = scaled + EXP_ROUND;
    const exp_words bits = (exp_words)n;
    const unsigned j = (unsigned)(bits[0] % EXP_STEPS);
    const unsigned k = (unsigned)(bits[1] % EXP_STEPS);
    const exp_words nearest = { EXP_BITS[j], EXP_BITS[k] };
    const exp_lanes tail = { EXP_TAIL[j], EXP_TAIL[k] };
    /* a shift, but of vectors gcc's analyzer takes none */
    const exp_lanes power = (exp_lanes)(nearest + bits * ((uint64_t)1 << EXP_SHIFT));
    const exp_lanes r = scaled - (n - EXP_ROUND);
    const exp_lanes r2 = r * r;
    const exp_lanes y = power + power * EXP_REST(r, r2, tail);

    result[0] = y[0];
    result[1] = y[1];
}

#else

static inline void exp_scaled_normal_pair(const real x[2], real result[2])
{
    for (int i = 0; i < 2; i++) {
        union {
            real value;
            uint64_t bits;
        } n = { x[i] + EXP_ROUND }, power;
        const unsigned j = (unsigned)(n.bits % EXP_STEPS);
        power.bits = EXP_BITS[j] + (n.bits << EXP_SHIFT);
        const real r = x[i] - (n.value - EXP_ROUND);
        const real r2 = r * r;
        result[i] = power.value + power.value * EXP_REST(r, r2, EXP_TAIL[j]);
    }
}

#endif

#endif

/* The same of any x <= 0, minus infinity included. */
static inline void exp_scaled_pair(const real x[2], real result[2])
{
#if defined IT2HYS_SINGLE /* an integer is made of it */
    const real normal[2] = { real_fmax(x[0], EXP_UNDERFLOW), real_fmax(x[1], EXP_UNDERFLOW) };
#else
    const real *normal = x;
#endif

    exp_scaled_normal_pair(normal, result);
    for (int i = 0; i < 2; i++)
        result[i] = x[i] < EXP_UNDERFLOW ? 0 : result[i];
}

struct it2_memberships {
    real lower[IT2_MAX_RULES];  /* f_l */
    real upper[IT2_MAX_RULES];  /* F_l */
    real weight[IT2_MAX_RULES]; /* f_l + F_l */
    real sum;                   /* D of (10) */
};

/* Below this sum some memberships have underflowed while others still count, or products with them have.
 * A membership with a scaled exponent above IT2_NO_UNDERFLOW is above it. The square of IT2_FARTHEST times an
 * exponent is finite: the widest rule stays the nearest one. */
#if defined IT2HYS_SINGLE
#define IT2_SUM_UNDERFLOW REAL(1e-12)
#define IT2_NO_UNDERFLOW (-39)
#define IT2_FARTHEST REAL(1e9)
#else
#define IT2_SUM_UNDERFLOW 1e-280
#define IT2_NO_UNDERFLOW (-59000)
#define IT2_FARTHEST 1e140
#endif

static inline void it2_exponents(const struct it2 *stage, int l, real y_previous, real scaled[2])
{
    const real distance = y_previous - stage->rule[l].centre;
    const real square = distance * distance;

    scaled[0] = square * stage->exponent[l][0];
    scaled[1] = square * stage->exponent[l][1];
}

/* (8), (11) and (9), (12) for one rule, where it2_is_plain; returns f_l + F_l. */
static inline real it2_membership(const struct it2 *stage, int l, real y_previous, real *lower, real *upper)
{
    real scaled[2];
    real membership[2] = { 0, 0 }; /* gcc's analyzer cannot follow the lanes */

    it2_exponents(stage, l, y_previous, scaled);
    exp_scaled_normal_pair(scaled, membership);
    *lower = membership[0];
    *upper = membership[1];
    return *lower + *upper;
}

HIDDEN_BEGIN
/* it2_memberships for any y_{k-1}. */
void it2_memberships_anywhere(const struct it2 *stage, real y_previous, struct it2_memberships *m);

/* An end of the range at y, from a stage that is (10) there; of an infinite one only that. */
struct it2_end it2_end_at(const struct it2 *stage, real y);

/* it2_gradient for y_{k-1} beyond an end. */
real it2_gradient_beyond(const struct it2 *stage, const struct it2_end *end, real y_previous, real x,
                         real *gradient, struct it2_partials *partials);
HIDDEN_END

static inline void it2_memberships(const struct it2 *stage, real y_previous, struct it2_memberships *m)
{
    if (!it2_is_plain(stage, y_previous)) {
        it2_memberships_anywhere(stage, y_previous, m);
        return;
    }
    m->sum = 0;
    for (int l = 0; l < stage->rules; l++) {
        m->weight[l] = it2_membership(stage, l, y_previous, &m->lower[l], &m->upper[l]);
        m->sum += m->weight[l];
    }
}

#define GRID 256
#define NEAR 5

/* A grid over the range with both its ends, and points at each rule's centre and one and two of its lower deviations
 * beside it: a narrow rule would hide between grid points. */
static int point_count(const struct it2 *stage)
{
    return GRID + 1 + NEAR * stage->rules;
}

static real point(const struct it2 *stage, struct it2_range range, int i)
{
    if (i == GRID)
        return range.maximum; /* the sum need not round to it */
    if (i < GRID)
        return range.minimum + (range.maximum - range.minimum) * (real)i / GRID;
    const struct it2_rule *rule = &stage->rule[(i - GRID - 1) / NEAR];
    const real y = rule->centre + (real)((i - GRID - 1) % NEAR - NEAR / 2) * rule->sigmaLower;
    return real_fmin(real_fmax(y, range.minimum), range.maximum);
}

static bool fail(char *message, size_t size, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(message, size, format, arguments);
    va_end(arguments);
    return false;
}

static bool check_rule(const struct it2_rule *rule, int number, char *message, size_t size)
{
    const real value[] = { rule->sigmaLower, rule->sigmaUpper, rule->centre, rule->q1, rule->q2, rule->q3 };
    static const char *const name[] = { "sigmaLower", "sigmaUpper", "centre", "q1", "q2", "q3" };

    for (int i = 0; i < IT2_RULE_PARAMETERS; i++)
        if (!isfinite(value[i]))
            return fail(message, size, "rule[%d].%s is not a finite number", number, name[i]);
    if (!(rule->sigmaLower > 0))
        return fail(message, size, "rule[%d].sigmaLower is %g; a standard deviation must be positive", number,
                    (double)rule->sigmaLower);
    if (!(rule->sigmaUpper >= rule->sigmaLower))
        return fail(message, size,
                    "rule[%d].sigmaUpper is %g, below rule[%d].sigmaLower, %g; the upper membership "
                    "must be the wider one (are the two swapped?)",
                    number, (double)rule->sigmaUpper, number, (double)rule->sigmaLower);
    return true;
}

/* dy_k/dx_k times the sum of memberships: the denominator of (30). */
static real denominator(const struct it2 *stage, real y)
{
    struct it2_memberships m;
    real slope = 0;

    it2_memberships(stage, y, &m);
    for (int l = 0; l < stage->rules; l++)
        slope += stage->rule[l].q2 * m.weight[l];
    return slope / m.sum;
}

real it2_contraction(const struct it2 *stage, struct it2_range range, real *where)
{
    real largest = -1;

    for (int i = 0; i < point_count(stage); i++) {
        const real y = point(stage, range, i);
        const real magnitude = real_fabs(it2_partials(stage, y, it2_solve(stage, y, y)).dy);
        if (!(magnitude <= largest)) { /* a NaN is the largest */
            largest = magnitude;
            *where = y;
        }
    }
    return largest;
}

bool it2_check(const struct it2_rule *rules, int count, struct it2_range range, char *message, size_t size)
{
    struct it2 stage;
    real where = range.minimum;

    if (count < 1 || count > IT2_MAX_RULES)
        return fail(message, size, "ruleCount is %d; it must be 1 to %d", count, IT2_MAX_RULES);
    if (!(isfinite(range.minimum) && isfinite(range.maximum) && range.minimum < range.maximum))
        return fail(message, size, "displacementMin, %g, must be below displacementMax, %g",
                    (double)range.minimum, (double)range.maximum);
    for (int l = 0; l < count; l++)
        if (!check_rule(&rules[l], l + 1, message, size))
            return false;
    it2_prepare(&stage, rules, count, IT2_EVERYWHERE);
    for (int i = 0; i < point_count(&stage); i++)
        if (!(denominator(&stage, point(&stage, range, i)) > 0))
            return fail(message, size,
                        "the sum of rule[].q2 times the memberships is not positive at a displacement "
                        "of %g: the model cannot be inverted there; raise q2 of the rules near it or "
                        "narrow displacementMin..displacementMax",
                        (double)point(&stage, range, i));
    const real contraction = it2_contraction(&stage, range, &where);
    if (!(contraction < 1))
        return fail(message, size,
                    "the contraction |dy_k/dy_{k-1}| is %.4g at a displacement of %g, where it must "
                    "be below 1: a free run diverges; lower rule[].q1 or narrow "
                    "displacementMin..displacementMax",
                    (double)contraction, (double)where);
    return true;
}

/* --- it2_gradient.c --- */

/* Eqs. (13) to (18): the partial derivatives of (10), and those with respect to x_k and y_{k-1}. */

/* (13) to (18) for one rule; `excess` is n_l - y_k, `share` 1 / D. Returns d(f_l + F_l)/dc_l, which is also
 * -d(f_l + F_l)/dy_{k-1}. Products with inverses: fits call this at every sample, and divisions were most of it. */
static real rule_gradient(const struct it2_rule *rule, real lower, real upper, real y_previous, real x,
                          real excess, real share, real *gradient)
{
    const real distance = y_previous - rule->centre;
    const real per_lower = 1 / rule->sigmaLower;
    const real per_upper = 1 / rule->sigmaUpper;
    const real lower_by_centre = lower * (per_lower * per_lower) * distance;
    const real upper_by_centre = upper * (per_upper * per_upper) * distance;
    const real weight = (lower + upper) * share;
    const real pull = excess * share;

    gradient[0] = lower_by_centre * distance * per_lower * pull;
    gradient[1] = upper_by_centre * distance * per_upper * pull;
    gradient[2] = (lower_by_centre + upper_by_centre) * pull;
    gradient[3] = y_previous * weight;
    gradient[4] = x * weight;
    gradient[5] = weight;
    return lower_by_centre + upper_by_centre;
}

real it2_gradient(const struct it2 *stage, real y_previous, real x, real *gradient,
                  struct it2_partials *partials)
{
    struct it2_memberships m;
    real consequent[IT2_MAX_RULES];
    real numerator = 0;
    real dx = 0;
    real dy = 0;

    const struct it2_end *end = it2_beyond(stage, y_previous);
    if (end)
        return it2_gradient_beyond(stage, end, y_previous, x, gradient, partials);
    it2_memberships(stage, y_previous, &m);
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        consequent[l] = rule->q1 * y_previous + (rule->q2 * x + rule->q3); /* as it2_evaluate */
        numerator += consequent[l] * m.weight[l];
    }
    const real y = numerator / m.sum;
    const real share = 1 / m.sum;
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        const real excess = consequent[l] - y;
        const real by_centre = rule_gradient(rule, m.lower[l], m.upper[l], y_previous, x, excess, share,
                                             gradient + IT2_RULE_PARAMETERS * l);
        dx += rule->q2 * m.weight[l];
        dy += rule->q1 * m.weight[l] - by_centre * excess;
    }
    if (partials)
        *partials = (struct it2_partials){ .dx = dx / m.sum, .dy = dy / m.sum, .end = 0 };
    return y;
}

struct it2_partials it2_partials(const struct it2 *stage, real y_previous, real x)
{
    real gradient[IT2_RULE_PARAMETERS * IT2_MAX_RULES];
    struct it2_partials partials;

    it2_gradient(stage, y_previous, x, gradient, &partials);
    return partials;
}

real it2_derivative(const struct it2 *stage, const struct it2_state *state, real x)
{
    return it2_partials(stage, state->y, x).dx;
}

/* --- it2_inverse.c --- */

/* Eq. (30): the voltage that takes the model from y_{k-1} to the desired y_k. */

real it2_solve_rules(const struct it2 *stage, real y_previous, real y)
{
    struct it2_memberships m;
    real free_response = 0;
    real slope = 0;

    if (!it2_is_plain(stage, y_previous)) {
        const struct it2_end *end = it2_beyond(stage, y_previous);
        if (end)
            return end->x + (y - end->y - end->dy * (y_previous - end->y)) / end->dx;
    }
    it2_memberships(stage, y_previous, &m);
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        free_response += (rule->q1 * y_previous + rule->q3) * m.weight[l];
        slope += rule->q2 * m.weight[l];
    }
    return (y * m.sum - free_response) / slope;
}

/* --- it2_model.c --- */

/* Eqs. (7) and (10): the rules' consequents, weighted by the memberships, without type reduction. */

/* Where the rule's memberships are above IT2_SUM_UNDERFLOW; empty where its parameters make no numbers. */
static struct it2_range rule_cannot_underflow(const struct it2_rule *rule, const real exponent[2])
{
    const real reach =
        real_fmin(real_sqrt(IT2_NO_UNDERFLOW / real_fmin(exponent[0], exponent[1])), IT2_FARTHEST);

    if (!(exponent[0] <= 0 && exponent[1] <= 0 && reach > 0 && isfinite(rule->centre)))
        return (struct it2_range){ REAL_INFINITY, -REAL_INFINITY };
    return (struct it2_range){ rule->centre - reach, rule->centre + reach };
}

static struct it2_range overlap(struct it2_range a, struct it2_range b)
{
    return (struct it2_range){ real_fmax(a.minimum, b.minimum), real_fmin(a.maximum, b.maximum) };
}

void it2_prepare(struct it2 *stage, const struct it2_rule *rules, int count, struct it2_range range)
{
    *stage = (struct it2){ .rules = count,
                           .plain = { -IT2_FARTHEST, IT2_FARTHEST },
                           .lower = { .y = -REAL_INFINITY },
                           .upper = { .y = REAL_INFINITY } };
    for (int l = 0; l < count; l++) {
        stage->rule[l] = rules[l];
        stage->exponent[l][0] = -REAL(0.5) * EXP_SCALE / (rules[l].sigmaLower * rules[l].sigmaLower);
        stage->exponent[l][1] = -REAL(0.5) * EXP_SCALE / (rules[l].sigmaUpper * rules[l].sigmaUpper);
        stage->plain = overlap(stage->plain, rule_cannot_underflow(&rules[l], stage->exponent[l]));
    }
    const struct it2_end lower = it2_end_at(stage, range.minimum);
    const struct it2_end upper = it2_end_at(stage, range.maximum);
    stage->lower = lower;
    stage->upper = upper;
    stage->plain = overlap(stage->plain, range);
}

/* exp of the differences of both scaled exponents to the largest, finite however narrow the rule is. */
static void relative(const real exponent[2], real square, real largest, real result[2])
{
    real difference[2];

    for (int i = 0; i < 2; i++)
        difference[i] = real_fmax(square * exponent[i], -REAL_MAX) - largest;
    exp_scaled_pair(difference, result);
}

/* Far from every centre all memberships underflow and (10) would be 0/0. Scaling all of them by the
 * largest leaves (10) as it is and finite; its limit is the nearest rule, the one whose distance in
 * units of its upper deviation is smallest. */
static void memberships_far(const struct it2 *stage, real y_previous, struct it2_memberships *m)
{
    real square[IT2_MAX_RULES];
    real largest = -REAL_MAX;

    for (int l = 0; l < stage->rules; l++) {
        const real distance =
            real_fmin(real_fmax(y_previous - stage->rule[l].centre, -IT2_FARTHEST), IT2_FARTHEST);
        square[l] = distance * distance;
        largest = real_fmax(largest, square[l] * stage->exponent[l][1]);
    }
    m->sum = 0;
    for (int l = 0; l < stage->rules; l++) {
        real membership[2];
        relative(stage->exponent[l], square[l], largest, membership);
        m->lower[l] = membership[0];
        m->upper[l] = membership[1];
        m->weight[l] = m->lower[l] + m->upper[l];
        m->sum += m->weight[l];
    }
}

void it2_memberships_anywhere(const struct it2 *stage, real y_previous, struct it2_memberships *m)
{
    m->sum = 0;
    for (int l = 0; l < stage->rules; l++) {
        real scaled[2], membership[2];
        it2_exponents(stage, l, y_previous, scaled);
        exp_scaled_pair(scaled, membership);
        m->lower[l] = membership[0];
        m->upper[l] = membership[1];
        m->weight[l] = m->lower[l] + m->upper[l];
        m->sum += m->weight[l];
    }
    if (!(m->sum >= IT2_SUM_UNDERFLOW))
        memberships_far(stage, y_previous, m);
}

static real consequent(const struct it2_rule *rule, real y_previous, real x)
{
    return rule->q1 * y_previous + (rule->q2 * x + rule->q3);
}

static real evaluate_elsewhere(const struct it2 *stage, real y_previous, real x)
{
    const struct it2_end *end = it2_beyond(stage, y_previous);
    struct it2_memberships m;
    real numerator = 0;

    if (end)
        return end->y + end->dx * (x - end->x) + end->dy * (y_previous - end->y);
    it2_memberships_anywhere(stage, y_previous, &m);
    for (int l = 0; l < stage->rules; l++)
        numerator += consequent(&stage->rule[l], y_previous, x) * m.weight[l];
    return numerator / m.sum;
}

real it2_evaluate_rules(const struct it2 *stage, real y_previous, real x)
{
    real lower, upper; /* not of interest here */
    real sum = 0;
    real numerator = 0;

    if (!it2_is_plain(stage, y_previous))
        return evaluate_elsewhere(stage, y_previous, x);
    for (int l = 0; l < stage->rules; l++) {
        const real weight = it2_membership(stage, l, y_previous, &lower, &upper);
        numerator += consequent(&stage->rule[l], y_previous, x) * weight;
        sum += weight;
    }
    return numerator / sum;
}

void it2_reset(struct it2_state *state, real y)
{
    state->y = y;
}

/* --- it2_range.c --- */

/* Beyond the ends of the range that a core was identified for.
 *
 * (10) extrapolates there with memberships that tend to the widest rule, whose own feedback may be more than
 * 1: it would diverge. So beyond an end y_e the core goes on as its linearisation at the equilibrium there,
 *     F(y, x) = y_e + A (x - x_e) + s (y - y_e),    A = dF/dx and s = dF/dy at (y_e, x_e), F(y_e, x_e) = y_e,
 * which contracts by s. (10) is affine in x with the slope A(y): at y_e nothing jumps, whatever x is. */

struct it2_end it2_end_at(const struct it2 *stage, real y)
{
    if (!isfinite(y))
        return (struct it2_end){ .y = y };
    const real x = it2_solve(stage, y, y);
    const struct it2_partials f = it2_partials(stage, y, x);
    return (struct it2_end){ .y = y, .x = x, .dx = f.dx, .dy = f.dy };
}

/* A rule at the equilibrium of an end: its weight w = f_l + F_l, and derivatives of w by y. */
struct rule_at_end {
    real weight;
    real slope;
    real curvature;
    real excess; /* n_l - y_e */
};

/* What a parameter of a rule changes there: w, dw/dy, n_l, and its coefficients of y and x. */
struct rule_change {
    real weight;
    real slope;
    real consequent;
    real q1;
    real q2;
};

/* Second derivatives of (10) there, and the sum of weights D with its derivative. */
struct curvature {
    real dxdy;
    real dydy;
    real sum;
    real slopes;
};

/* How far (y_{k-1}, x_k) is from it. */
struct distance {
    real y;
    real x;
};

static struct rule_at_end at_end(const struct it2_rule *rule, const struct it2_end *end, real lower, real upper)
{
    const real distance = end->y - rule->centre;
    const real square_lower = rule->sigmaLower * rule->sigmaLower;
    const real square_upper = rule->sigmaUpper * rule->sigmaUpper;
    const real ratio_lower = distance * distance / square_lower;
    const real ratio_upper = distance * distance / square_upper;

    return (struct rule_at_end){
        .weight = lower + upper,
        .slope = -distance * (lower / square_lower + upper / square_upper),
        .curvature = lower * (ratio_lower - 1) / square_lower + upper * (ratio_upper - 1) / square_upper,
        .excess = rule->q1 * end->y + (rule->q2 * end->x + rule->q3) - end->y,
    };
}

static struct rule_change by_deviation(real membership, real distance, real sigma)
{
    const real ratio = distance * distance / (sigma * sigma);

    return (struct rule_change){
        .weight = membership * ratio / sigma,
        .slope = membership * distance * (2 - ratio) / (sigma * sigma * sigma),
    };
}

/* In the order of struct it2_rule. */
static void rule_changes(const struct it2_rule *rule, const struct it2_end *end, real lower, real upper,
                         const struct rule_at_end *at, struct rule_change change[IT2_RULE_PARAMETERS])
{
    const real distance = end->y - rule->centre;

    change[0] = by_deviation(lower, distance, rule->sigmaLower);
    change[1] = by_deviation(upper, distance, rule->sigmaUpper);
    change[2] = (struct rule_change){ .weight = -at->slope, .slope = -at->curvature };
    change[3] = (struct rule_change){ .consequent = end->y, .q1 = 1 };
    change[4] = (struct rule_change){ .consequent = end->x, .q2 = 1 };
    change[5] = (struct rule_change){ .consequent = 1 };
}

/* dF/dp = dA/dp (x - x_e) - A dx_e/dp + ds/dp (y - y_e), where (10) changes by d at (y_e, x_e) and
 * dx_e/dp = -d / A brings it back to y_e. */
static real by_parameter(const struct it2_rule *rule, const struct it2_end *end, const struct curvature *f,
                         const struct rule_at_end *at, const struct rule_change *change, struct distance from)
{
    const real d = (change->consequent * at->weight + at->excess * change->weight) / f->sum;
    const real dA = (change->q2 * at->weight + (rule->q2 - end->dx) * change->weight) / f->sum;
    const real ds = (change->q1 * at->weight + (rule->q1 - end->dy) * change->weight +
                     change->consequent * at->slope + at->excess * change->slope - d * f->slopes) /
                    f->sum;

    return dA * from.x + d + (ds - f->dxdy * d / end->dx) * from.y;
}

real it2_gradient_beyond(const struct it2 *stage, const struct it2_end *end, real y_previous, real x,
                         real *gradient, struct it2_partials *partials)
{
    const struct distance from = { y_previous - end->y, x - end->x };
    struct it2_memberships m;
    struct rule_at_end at[IT2_MAX_RULES];
    struct rule_change change[IT2_RULE_PARAMETERS];

    it2_memberships(stage, end->y, &m);
    struct curvature f = { .sum = m.sum };
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        at[l] = at_end(rule, end, m.lower[l], m.upper[l]);
        f.slopes += at[l].slope;
        f.dxdy += (rule->q2 - end->dx) * at[l].slope / m.sum;
        f.dydy += (2 * (rule->q1 - end->dy) * at[l].slope + at[l].excess * at[l].curvature) / m.sum;
    }
    for (int l = 0; l < stage->rules; l++) {
        rule_changes(&stage->rule[l], end, m.lower[l], m.upper[l], &at[l], change);
        for (int i = 0; i < IT2_RULE_PARAMETERS; i++)
            gradient[IT2_RULE_PARAMETERS * l + i] =
                by_parameter(&stage->rule[l], end, &f, &at[l], &change[i], from);
    }
    if (partials)
        *partials = (struct it2_partials){
            .dx = end->dx,
            .dy = end->dy,
            .end = f.dxdy * from.x + (f.dydy + f.dxdy * (1 - end->dy) / end->dx) * from.y,
        };
    return end->y + end->dx * from.x + end->dy * from.y;
}

/* --- it2_table.c --- */

/* Makes the table of it2_table.h. */

/* The first try is a width of at most this share of the smallest deviation. */
#define TABLE_WIDTHS_PER_DEVIATION 8

/* What an interpolation may be off by, in units of what it is added to: less than half a rounding error. */
#define TABLE_TOLERANCE (REAL_EPSILON / 4)

/* Terms as small as this are rounding errors of those that they were made of. */
#define TABLE_NOISE (2 * REAL_EPSILON)

/* Of widths from 0: beyond it, numbers of rows do not stand in the low bits. */
#define TABLE_FARTHEST 1e9

enum { TABLE_HALF = IT2_TABLE_TERMS / 2 };

#if !defined IT2HYS_SINGLE

/* Chebyshev nodes to the right of the middle, in widths, outermost first: cos((2 k + 1) pi / 16) / 2. */
static const real NODE[TABLE_HALF] = { 0.4903926402016152, 0.4157348061512726, 0.2777851165098011,
                                       0.09754516100806414 };

/* What is interpolated there is, in powers of the distance from the middle in widths, of even degree by sums
 * of what it is at a node and at the one opposite, and of odd degree by differences. */
static const real EVEN[TABLE_HALF][TABLE_HALF] = {
    { -0.02486404592245725, 0.08352232973991236, -0.18707572033318612, 0.628417436515731 },
    { 3.079206598101809, -10.207610470980601, 21.521318969965364, -14.39291509708657 },
    { -50.847802016127716, 154.75745324419754, -200.01228724013657, 96.10263601206675 },
    { 195.93391737092597, -473.0263206457788, 473.0263206457788, -195.93391737092597 },
};
static const real ODD[TABLE_HALF][TABLE_HALF] = {
    { -0.05070232275964601, 0.20090290373599667, -0.6734548009039408, 6.442323022705137 },
    { 6.279063643442639, -24.553177458195258, 77.4747014540141, -147.55129776142044 },
    { -103.68793869994184, 372.2504128939501, -720.0252114050161, 985.2117216160203 },
    { 399.5449794890307, -1137.8078372241453, 1702.8497659956126, -2008.648254265816 },
};

/* Chebyshev's polynomial of degree n, scaled to a width, begins with 2^(2 n - 1): what a term's coefficient
 * in these is, as long as the next but one is small beside it. */
static real chebyshev(real coefficient, int degree)
{
    return real_fabs(coefficient) / (real)(1 << (2 * degree - 1));
}

static real dot(const real a[TABLE_HALF], const real b[TABLE_HALF])
{
    return (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]);
}

/* A and B at y, by the rules. */
static void evaluate(const struct it2 *stage, real y, real value[2])
{
    struct it2_memberships m;

    value[0] = value[1] = 0;
    it2_memberships(stage, y, &m);
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        value[0] += rule->q2 * m.weight[l];
        value[1] += (rule->q1 * y + rule->q3) * m.weight[l];
    }
    value[0] /= m.sum;
    value[1] /= m.sum;
}

/* The terms for A or B, in widths, from what it is at nodes to the right and to the left; returns whether they
 * have converged for what is of the size `size`. */
static bool interpolate(const real right[TABLE_HALF], const real left[TABLE_HALF], real size,
                        real term[IT2_TABLE_TERMS])
{
    const real near = right[TABLE_HALF - 1]; /* only differences to it are small */
    real sum[TABLE_HALF], difference[TABLE_HALF];

    for (int k = 0; k < TABLE_HALF; k++) {
        sum[k] = (right[k] - near) + (left[k] - near);
        difference[k] = right[k] - left[k];
    }
    for (int j = 0; j < TABLE_HALF; j++) {
        term[2 * j] = dot(EVEN[j], sum);
        term[2 * j + 1] = dot(ODD[j], difference);
    }
    /* the next two terms, left out, fall short of the last two as these do of the two before */
    const real before = chebyshev(term[4], 4) + chebyshev(term[5], 5);
    const real last = chebyshev(term[6], 6) + chebyshev(term[7], 7);
    term[0] += near;
    return last <= TABLE_NOISE * size || last * last <= TABLE_TOLERANCE * size * before;
}

/* One row, around `middle`; returns whether it holds A and B to rounding. */
static bool make_row(const struct it2 *stage, real middle, real width, const real size[2],
                     real row[IT2_TABLE_TERMS][2])
{
    const real per_width = 1 / width;
    real right[2][TABLE_HALF], left[2][TABLE_HALF], value[2], term[IT2_TABLE_TERMS];
    bool converged = true;

    for (int k = 0; k < TABLE_HALF; k++) {
        evaluate(stage, middle + width * NODE[k], value);
        right[0][k] = value[0], right[1][k] = value[1];
        evaluate(stage, middle - width * NODE[k], value);
        left[0][k] = value[0], left[1][k] = value[1];
    }
    for (int i = 0; i < 2; i++) {
        real power = 1;
        converged &= interpolate(right[i], left[i], size[i], term);
        for (int j = 0; j < IT2_TABLE_TERMS; j++, power *= per_width)
            row[j][i] = term[j] * power;
    }
    return converged;
}

/* With intervals of a width, a power of two. */
static bool make_rows(struct it2_table *table, const struct it2 *stage, real width)
{
    const real low = table->range.minimum, high = table->range.maximum;
    const real length = real_fmax(real_fmax(real_fabs(low), real_fabs(high)), high - low);
    const real voltage = real_fmax(real_fabs(stage->lower.x), real_fabs(stage->upper.x));
    const real size[2] = { length / voltage, length };

    const real all = REAL(6755399441055744.0) * width;
    const real first = (low + all) - all;
    table->rounding = all - first;
    const int rows = (int)it2_table_row(high + table->rounding) + 1;
    for (int i = 0; i < rows; i++)
        if (!make_row(stage, first + (real)i * width, width, size, table->term[i]))
            return false;
    table->rows = rows;
    return true;
}

/* The largest power of two that is not larger. */
static real power_of_two(real value)
{
    real power = 1;

    while (power > value)
        power /= 2;
    while (2 * power <= value)
        power *= 2;
    return power;
}

static bool has_room(struct it2_range range, real width)
{
    const real farthest = real_fmax(real_fabs(range.minimum), real_fabs(range.maximum));

    return range.maximum - range.minimum <= (IT2_TABLE_ROWS - 2) * width && farthest <= TABLE_FARTHEST * width;
}

/* Finer and finer, as long as there is room. */
static void fill(struct it2_table *table, const struct it2 *stage)
{
    const real low = table->range.minimum, high = table->range.maximum;
    real deviation = high - low;

    table->rows = 0;
    for (int l = 0; l < stage->rules; l++)
        deviation = real_fmin(deviation, stage->rule[l].sigmaLower);
    if (!(deviation > 0 && isfinite(deviation)))
        return;
    for (real width = power_of_two(deviation / TABLE_WIDTHS_PER_DEVIATION); has_room(table->range, width);
         width /= 2)
        if (make_rows(table, stage, width))
            return;
}

static bool is_of(const struct it2_table *table, const struct it2 *stage)
{
    return table->rules == stage->rules && table->range.minimum == stage->plain.minimum &&
           table->range.maximum == stage->plain.maximum &&
           memcmp(table->rule, stage->rule, (size_t)stage->rules * sizeof *stage->rule) == 0;
}

bool it2_tabulate(struct it2 *stage, struct it2_table *table)
{
    if (!is_of(table, stage)) {
        table->rules = stage->rules;
        table->range = stage->plain;
        memcpy(table->rule, stage->rule, sizeof table->rule);
        fill(table, stage);
    }
    stage->table = table->rows > 0 ? table : NULL;
    return stage->table;
}

#else

bool it2_tabulate(struct it2 *stage, struct it2_table *table)
{
    (void)table;
    stage->table = NULL;
    return false;
}

#endif

/* --- lag.c --- */

/* A slower pole would leave too few digits for the inverse. */
#define LAG_SLOWEST REAL(1e9) /* sample times */

static bool lag_check(const struct chain_parameters *p, char *message, size_t size)
{
    const real time_constant = p->lag.timeConstant;

    if (!(time_constant >= 0))
        return refuse(message, size, "lag.timeConstant is %g s; it must be positive, or 0 for no lag",
                      (double)time_constant);
    if (!(time_constant <= LAG_SLOWEST * p->sampleTime))
        return refuse(message, size,
                      "lag.timeConstant is %g s; at a sampleTime of %g s it must be at "
                      "most %g s",
                      (double)time_constant, (double)p->sampleTime, (double)(LAG_SLOWEST * p->sampleTime));
    return true;
}

static bool lag_is_on(const struct chain_parameters *p)
{
    return p->lag.timeConstant > 0;
}

static void lag_prepare(void *constants, const struct chain_parameters *p)
{
    struct lag *lag = constants;

    lag->gain = -real_expm1(-p->sampleTime / p->lag.timeConstant);
    lag->per_gain = 1 / lag->gain;
}

static real lag_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct lag *lag = constants;
    struct lag_state *s = state;

    (void)around;
    s->y += lag->gain * (x - s->y);
    return s->y;
}

static real lag_inverse(const void *constants, void *state, real y, const struct stage_surroundings *around)
{
    const struct lag *lag = constants;
    struct lag_state *s = state;
    const real x = s->y + (y - s->y) * lag->per_gain;

    (void)around;
    s->y = y;
    return x;
}

static void lag_prepare_tangent(void *d_constants, const void *constants, const struct chain_parameters *p,
                                const struct chain_parameters *d)
{
    const real time_constant = p->lag.timeConstant;
    const real ratio = p->sampleTime / time_constant;
    struct lag *result = d_constants;

    (void)constants;
    result->gain = -ratio / time_constant * real_exp(-ratio) * d->lag.timeConstant;
}

static void lag_tangent(const void *constants, const void *state, real x,
                        const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                        int count, real *restrict d_state, real *restrict row)
{
    const struct lag *lag = constants;

    (void)around, (void)state, (void)x, (void)d_around;
    for (int c = 0; c < count; c++) {
        d_state[c] += lag->gain * (row[c] - d_state[c]);
        row[c] = d_state[c];
    }
}

static real lag_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                              const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct lag *d = d_constants;
    const struct lag_state *s = state;
    const real moved = d->gain * (x - s->y);

    (void)constants, (void)around, (void)stride;
    d_state[0] += moved;
    return moved;
}

static real lag_inverse_tangent(const void *constants, const void *state, real x, void *d_state, real d_y,
                                const struct stage_surroundings *around,
                                const struct stage_surroundings *d_around)
{
    (void)around, (void)state, (void)x;
    return lag_inverse(constants, d_state, d_y, d_around); /* it is linear */
}

const struct stage lag_stage = {
    .is_on = lag_is_on,
    .prepare = lag_prepare,
    .step = lag_step,
    .inverse = lag_inverse,
};

const struct stage_analysis lag_analysis = {
    .check = lag_check,
    .prepare_tangent = lag_prepare_tangent,
    .tangent = lag_tangent,
    .by_parameters = lag_by_parameters,
    .inverse_tangent = lag_inverse_tangent,
};

/* --- load.c --- */

static bool load_check(const struct chain_parameters *p, char *message, size_t size)
{
    if (!(p->load.compliance >= 0))
        return refuse(message, size,
                      "load.compliance is %g m/N; it must not be negative (force is "
                      "compressive positive)",
                      (double)p->load.compliance);
    return true;
}

static bool load_is_on(const struct chain_parameters *p)
{
    return p->load.compliance != 0;
}

static void load_prepare(void *constants, const struct chain_parameters *p)
{
    struct load *load = constants;

    load->compliance = p->load.compliance;
}

static real load_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct load *load = constants;

    (void)state;
    return x - load->compliance * around->force;
}

static real load_inverse(const void *constants, void *state, real y, const struct stage_surroundings *around)
{
    const struct load *load = constants;

    (void)state;
    return y + load->compliance * around->force;
}

static void load_tangent(const void *constants, const void *state, real x,
                         const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                         int count, real *restrict d_state, real *restrict row)
{
    const struct load *load = constants;

    (void)around, (void)state, (void)x, (void)d_state;
    for (int c = 0; c < count; c++)
        row[c] -= load->compliance * d_around[c].force;
}

static real load_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                               const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct load *d = d_constants;

    (void)constants, (void)state, (void)x, (void)d_state, (void)stride;
    return -d->compliance * around->force;
}

static real load_inverse_tangent(const void *constants, const void *state, real x, void *d_state, real d_y,
                                 const struct stage_surroundings *around,
                                 const struct stage_surroundings *d_around)
{
    (void)around, (void)state, (void)x;
    return load_inverse(constants, d_state, d_y, d_around); /* it is linear */
}

const struct stage load_stage = {
    .is_on = load_is_on,
    .prepare = load_prepare,
    .step = load_step,
    .inverse = load_inverse,
};

const struct stage_analysis load_analysis = {
    .check = load_check,
    .tangent = load_tangent,
    .by_parameters = load_by_parameters,
    .inverse_tangent = load_inverse_tangent,
};

/* --- nonlinearity.c --- */

#define CURVE_GRID 256

/* Of the inverse: 3 to 8 are usual, halving alone takes 53 to the last digit. */
#define MOST_STEPS 120

static bool nonlinearity_is_on(const struct chain_parameters *p)
{
    const struct nonlinearity_parameters *c = &p->nonlinearity;

    return c->quadratic != 0 || c->cubic != 0 || c->quartic != 0 || c->quintic != 0 || c->sextic != 0;
}

/* The curve, or its derivative, which is linear in the parameters. */
static void nonlinearity_set(struct nonlinearity *curve, const struct chain_parameters *p)
{
    const struct nonlinearity_parameters *c = &p->nonlinearity;

    curve->coefficient = *c;
    curve->centre = p->displacementZero + REAL(0.5) * (c->minimum + c->maximum);
    curve->half_range = REAL(0.5) * (c->maximum - c->minimum);
}

/* What the curve adds to the straight line, and its derivative by z. */
struct nonlinearity_bow {
    real value;
    real slope;
};

/* Between the ends, z from -1 to 1: (1 - z^2) times a polynomial, of pairs that do not wait for each other. */
static inline struct nonlinearity_bow nonlinearity_bow(const struct nonlinearity_parameters *c, real z)
{
    const real z2 = z * z, ends = 1 - z2;
    const real inner = (c->quadratic + c->cubic * z) + ((c->quartic + c->quintic * z) + c->sextic * z2) * z2;
    const real by_z = (c->cubic + 2 * c->quartic * z) + (3 * c->quintic + 4 * c->sextic * z) * z2;

    return (struct nonlinearity_bow){ ends * inner, ends * by_z - 2 * z * inner };
}

/* The same numbers, sooner, where the curve is at most cubic: an inverse waits for each of these. */
static inline struct nonlinearity_bow nonlinearity_bow_of(bool cubic, const struct nonlinearity_parameters *c,
                                                          real z)
{
    const real ends = 1 - z * z, inner = c->quadratic + c->cubic * z;

    if (!cubic)
        return nonlinearity_bow(c, z);
    return (struct nonlinearity_bow){ ends * inner, ends * c->cubic - 2 * z * inner };
}

/* Where z + bow(z) = aim, to the first order in the bow. */
static inline real nonlinearity_guess(bool cubic, const struct nonlinearity_parameters *c, real aim)
{
    const struct nonlinearity_bow bow = nonlinearity_bow_of(cubic, c, aim);

    return aim - bow.value * (1 - bow.slope);
}

/* How many steps of Newton's method solve a curve from that guess, whatever the aim is, to rounding; 0 where that is
 * not sure. From the aim to where z + bow(z) = aim it is d = -bow(z), and the guess is off by at most
 * tilt^2 |d| + bend d^2: tilt bounds |dbow/dz|, bend half the second derivative. A step leaves the square of what
 * it finds, times bend / (1 - tilt), where z may be somewhat beyond the ends, up to |z| = 1.3. */
static int nonlinearity_steps(const struct nonlinearity_parameters *c)
{
    const real q = real_fabs(c->quadratic), k = real_fabs(c->cubic), l = real_fabs(c->quartic);
    const real m = real_fabs(c->quintic), n = real_fabs(c->sextic);
    const real d = q + REAL(0.4) * k + REAL(0.25) * l + REAL(0.19) * m + REAL(0.15) * n;
    const real tilt = 2 * (q + k + l + m + n), bend = q + 3 * k + 5 * l + 7 * m + 9 * n;
    const real tilt_beyond = 3 * q + 5 * k + 7 * l + 10 * m + 14 * n;
    const real bend_beyond = q + 4 * k + 10 * l + 19 * m + 33 * n;
    real error = (tilt * tilt + bend * d) * d;

    if (!(tilt_beyond <= REAL(0.5) && error <= REAL(0.1)))
        return 0;
    for (int steps = 1;; steps++) {
        error *= bend_beyond / (1 - tilt_beyond) * error;
        if (error <= REAL(0.25) * REAL_EPSILON)
            return steps;
    }
}

static void nonlinearity_prepare(void *constants, const struct chain_parameters *p)
{
    struct nonlinearity *curve = constants;
    struct nonlinearity_parameters *scaled = &curve->scaled;

    nonlinearity_set(curve, p);
    curve->per_half_range = 1 / curve->half_range;
    scaled->quadratic = curve->coefficient.quadratic / curve->half_range;
    scaled->cubic = curve->coefficient.cubic / curve->half_range;
    scaled->quartic = curve->coefficient.quartic / curve->half_range;
    scaled->quintic = curve->coefficient.quintic / curve->half_range;
    scaled->sextic = curve->coefficient.sextic / curve->half_range;
    curve->cubic = p->nonlinearity.quartic == 0 && p->nonlinearity.quintic == 0 && p->nonlinearity.sextic == 0;
    curve->steps = nonlinearity_steps(scaled);
}

static real nonlinearity_step(const void *constants, void *state, real x,
                              const struct stage_surroundings *around)
{
    const struct nonlinearity *curve = constants;
    const real z = (x - curve->centre) * curve->per_half_range;
    const real end = clamp(z, -1, 1);

    (void)state, (void)around;
    if (z != end)
        return x + nonlinearity_bow(&curve->coefficient, end).slope * (z - end);
    return x + nonlinearity_bow_of(curve->cubic, &curve->coefficient, z).value;
}

/* On the curve between the ends, by x. */
static real nonlinearity_slope(const struct nonlinearity *curve, real z)
{
    return 1 + nonlinearity_bow(&curve->coefficient, z).slope / curve->half_range;
}

/* How far the curve at z is above the aim, and what Newton's method adds to z then. */
struct nonlinearity_miss {
    real excess;
    real newton;
};

static inline struct nonlinearity_miss nonlinearity_miss(bool cubic, const struct nonlinearity *curve, real z,
                                                         real aim)
{
    const struct nonlinearity_bow bow = nonlinearity_bow_of(cubic, &curve->scaled, z);
    const real excess = z - aim + bow.value;

    return (struct nonlinearity_miss){ excess, -excess / (1 + bow.slope) };
}

/* Newton's method in z within a bracket that every step narrows, which is halved instead where Newton would
 * leave it or does not halve its own step. */
static real nonlinearity_search(const struct nonlinearity *curve, real aim)
{
    real low = -1, high = 1, z = aim, step = 2;

    for (int i = 0; i < MOST_STEPS; i++) {
        const struct nonlinearity_miss miss = nonlinearity_miss(false, curve, z, aim);
        if (real_fabs(miss.excess) <= REAL_EPSILON)
            break;
        if (miss.excess > 0)
            high = z;
        else
            low = z;
        const bool well = z + miss.newton >= low && z + miss.newton <= high &&
                          real_fabs(miss.newton) <= REAL(0.5) * real_fabs(step);
        step = well ? miss.newton : REAL(0.5) * (low + high) - z;
        if (z + step == z)
            break;
        z += step;
    }
    return z;
}

/* A curve that bends little takes a number of steps that is known before: nothing has to be decided. */
static inline real nonlinearity_solve(bool cubic, const struct nonlinearity *curve, real aim)
{
    real z = nonlinearity_guess(cubic, &curve->scaled, aim);

    for (int i = 0; i < curve->steps; i++)
        z += nonlinearity_miss(cubic, curve, z, aim).newton;
    return curve->centre + curve->half_range * z;
}

static real nonlinearity_inverse(const void *constants, void *state, real y,
                                 const struct stage_surroundings *around)
{
    const struct nonlinearity *curve = constants;
    const real aim = (y - curve->centre) * curve->per_half_range;

    (void)state, (void)around;
    if (!(aim > -1 && aim < 1)) {
        const real end = clamp(aim, -1, 1);
        return curve->centre + curve->half_range * (end + (aim - end) / nonlinearity_slope(curve, end));
    }
    if (curve->steps == 0)
        return curve->centre + curve->half_range * nonlinearity_search(curve, aim);
    return curve->cubic ? nonlinearity_solve(true, curve, aim) : nonlinearity_solve(false, curve, aim);
}

static real nonlinearity_rest(const void *constants, void *state, real y, const struct chain_parameters *p)
{
    (void)p;
    return nonlinearity_inverse(constants, state, y, NULL);
}

static void nonlinearity_prepare_tangent(void *d_constants, const void *constants,
                                         const struct chain_parameters *p, const struct chain_parameters *d)
{
    (void)constants, (void)p;
    nonlinearity_set(d_constants, d);
}

static real nonlinearity_place(const struct nonlinearity *curve, real x)
{
    return (x - curve->centre) / curve->half_range;
}

static real nonlinearity_derivative(const struct nonlinearity *curve, real x)
{
    return nonlinearity_slope(curve, clamp(nonlinearity_place(curve, x), -1, 1));
}

static void nonlinearity_tangent(const void *constants, const void *state, real x,
                                 const struct stage_surroundings *around,
                                 const struct stage_surroundings *d_around, int count, real *restrict d_state,
                                 real *restrict row)
{
    const real slope = nonlinearity_derivative(constants, x);

    (void)around, (void)state, (void)d_around, (void)d_state;
    for (int c = 0; c < count; c++)
        row[c] *= slope;
}

static real nonlinearity_by_parameters(const void *constants, const void *d_constants, const void *state,
                                       real x, const struct stage_surroundings *around, real *d_state,
                                       int stride)
{
    const struct nonlinearity *curve = constants, *d = d_constants;
    const real z = nonlinearity_place(curve, x), end = clamp(z, -1, 1);

    (void)state, (void)around, (void)d_state, (void)stride;
    const struct nonlinearity_bow d_bow = nonlinearity_bow(&d->coefficient, end);
    return d_bow.value + d_bow.slope * (z - end) -
           (nonlinearity_slope(curve, end) - 1) * (d->centre + z * d->half_range);
}

static real nonlinearity_inverse_tangent(const void *constants, const void *state, real x, void *d_state,
                                         real d_y, const struct stage_surroundings *around,
                                         const struct stage_surroundings *d_around)
{
    (void)around, (void)state, (void)d_state, (void)d_around;
    return d_y / nonlinearity_derivative(constants, x);
}

static real nonlinearity_rest_tangent(const void *constants, const void *d_constants, const void *state,
                                      void *d_state, real x, real d_y, const struct chain_parameters *p,
                                      const struct chain_parameters *d)
{
    const real by = nonlinearity_by_parameters(constants, d_constants, NULL, x, NULL, NULL, 0);

    (void)state, (void)d_state, (void)p, (void)d;
    return (d_y - by) / nonlinearity_derivative(constants, x);
}

static bool nonlinearity_check(const struct chain_parameters *p, char *message, size_t size)
{
    struct nonlinearity curve;

    if (!nonlinearity_is_on(p))
        return true;
    if (!(p->nonlinearity.minimum < p->nonlinearity.maximum))
        return refuse(message, size,
                      "nonlinearity.minimum, %g m, must be below nonlinearity.maximum, "
                      "%g m",
                      (double)p->nonlinearity.minimum, (double)p->nonlinearity.maximum);
    nonlinearity_prepare(&curve, p);
    for (int i = 0; i <= CURVE_GRID; i++) {
        const real z = 2 * (real)i / CURVE_GRID - 1;
        if (!(nonlinearity_slope(&curve, z) > 0))
            return refuse(message, size,
                          "nonlinearity.quadratic to nonlinearity.sextic make a curve that "
                          "falls %g m above displacementZero; it must rise from nonlinearity.minimum "
                          "to nonlinearity.maximum",
                          (double)(curve.centre - p->displacementZero + z * curve.half_range));
    }
    return true;
}

const struct stage nonlinearity_stage = {
    .is_on = nonlinearity_is_on,
    .prepare = nonlinearity_prepare,
    .rest = nonlinearity_rest,
    .step = nonlinearity_step,
    .inverse = nonlinearity_inverse,
};

const struct stage_analysis nonlinearity_analysis = {
    .check = nonlinearity_check,
    .prepare_tangent = nonlinearity_prepare_tangent,
    .rest_tangent = nonlinearity_rest_tangent,
    .tangent = nonlinearity_tangent,
    .by_parameters = nonlinearity_by_parameters,
    .inverse_tangent = nonlinearity_inverse_tangent,
};

/* --- play.c --- */

static bool play_check(const struct chain_parameters *p, char *message, size_t size)
{
    const struct play_element *elements = p->play;
    real slope = 1;

    if (p->playCount < 0 || p->playCount > PLAY_MAX)
        return refuse(message, size, "playCount is %d; it must be 0 to %d", p->playCount, PLAY_MAX);
    for (int j = 0; j < p->playCount; j++) {
        const real least = j > 0 ? elements[j - 1].threshold : 0;
        if (!(elements[j].threshold >= least))
            return refuse(message, size,
                          "play[%d].threshold is %g V; thresholds must rise, so it must be "
                          "at least %g V",
                          j + 1, (double)elements[j].threshold, (double)least);
        slope += elements[j].weight;
        if (!(slope > 0))
            return refuse(message, size,
                          "1 plus the weights up to play[%d].weight is %g; it must be "
                          "positive: the play operators would not be monotone and could not be inverted",
                          j + 1, (double)slope);
    }
    return true;
}

static bool play_is_on(const struct chain_parameters *p)
{
    return p->playCount > 0;
}

static bool play_is_idle(const struct chain_parameters *p)
{
    for (int j = 0; j < p->playCount; j++)
        if (p->play[j].weight != 0)
            return false;
    return true;
}

static void play_prepare(void *constants, const struct chain_parameters *p)
{
    struct play *play = constants;

    play->first = 0;
    play->count = p->playCount;
    for (int j = 0; j < play->count; j++)
        play->element[j] = p->play[j];
}

static size_t play_used(const void *constants)
{
    const struct play *play = constants;

    return (size_t)play->count * sizeof(real);
}

static real play_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct play *play = constants;
    struct play_state *s = state;
    real h = x;

    (void)around;
    for (int j = 0; j < play->count; j++) {
        const real r = play->element[j].threshold;
        s->p[j] = clamp(s->p[j], x - r, x + r);
        h += play->element[j].weight * s->p[j];
    }
    return h;
}

/* Walks from the segment in which no operator moves, upwards (side 1) or downwards (side -1), to the
 * segment that holds h. On a segment: slope x = sum. */
static real play_walk(const struct play *play, const struct play_state *s, real sum, real side)
{
    real slope = 1;
    real x = sum;

    for (int j = 0; j < play->count; j++) {
        const real corner = s->p[j] + side * play->element[j].threshold;
        if (!(side * (x - corner) > 0))
            break;
        sum += play->element[j].weight * corner;
        slope += play->element[j].weight;
        x = sum / slope;
    }
    return x;
}

static real play_inverse(const void *constants, void *state, real h, const struct stage_surroundings *around)
{
    const struct play *play = constants;
    const struct play_state *s = state;
    real sum = h;

    (void)around;
    for (int j = 0; j < play->count; j++)
        sum -= play->element[j].weight * s->p[j];
    return play_walk(play, s, sum, sum > s->p[0] ? 1 : -1);
}

/* Demagnetised, driven to the turning point, and from there to where the output is h. */
static real play_rest(const void *constants, void *state, real h, const struct chain_parameters *p)
{
    const struct play *play = constants;
    struct play_state *s = state;

    *s = (struct play_state){ { 0 } };
    for (int j = 0; j < play->count; j++)
        s->p[j] = p->initialDemagnetisation;
    play_step(play, s, p->initialDemagnetisation + p->initialExcursion, NULL);
    const real x = play_inverse(play, s, h, NULL);
    play_step(play, s, x, NULL);
    return x;
}

/* Does x move operator j: upwards 1, downwards -1, or not? */
static int play_moves(const struct play *play, const struct play_state *s, int j, real x)
{
    const real r = play->element[j].threshold;

    return (s->p[j] < x - r) - (s->p[j] > x + r);
}

static void play_prepare_tangent(void *d_constants, const void *constants, const struct chain_parameters *p,
                                 const struct chain_parameters *d)
{
    const struct play *play = constants;
    struct play *result = d_constants;

    (void)p;
    for (int j = play->count - 1; j >= 0; j--) {
        result->element[j] = d->play[j];
        if (d->play[j].threshold == 0 && d->play[j].weight == 0)
            continue;
        result->first = j;
        result->count = result->count ? result->count : j + 1;
    }
}

/* An operator's output, its derivative, and whether it has moved. */
struct play_moved {
    real p;
    real d_p;
    bool moved;
};

/* Once the input has come to x. */
static struct play_moved play_move(struct play_moved from, real threshold, real d_threshold, real x, real d_x)
{
    if (x - threshold > from.p)
        return (struct play_moved){ x - threshold, d_x - d_threshold, true };
    if (x + threshold < from.p)
        return (struct play_moved){ x + threshold, d_x + d_threshold, true };
    return (struct play_moved){ from.p, from.d_p, false };
}

static real play_rest_tangent(const void *constants, const void *d_constants, const void *state, void *d_state,
                              real x, real d_h, const struct chain_parameters *p,
                              const struct chain_parameters *d)
{
    const struct play *play = constants, *by = d_constants;
    const struct play_moved new = { p->initialDemagnetisation, d->initialDemagnetisation, false };
    const real turn = p->initialDemagnetisation + p->initialExcursion;
    const real d_turn = d->initialDemagnetisation + d->initialExcursion;
    struct play_moved last[PLAY_MAX];
    struct play_state *s = d_state;
    real slope = 1;

    (void)state;
    for (int j = 0; j < play->count; j++) {
        const struct play_element *element = &play->element[j], *d_element = &by->element[j];
        const struct play_moved turned = play_move(new, element->threshold, d_element->threshold, turn, d_turn);
        last[j] = play_move(turned, element->threshold, d_element->threshold, x, 0);
        d_h -= d_element->weight * last[j].p + element->weight * last[j].d_p;
        if (last[j].moved)
            slope += element->weight;
    }
    const real d_x = d_h / slope;
    for (int j = 0; j < play->count; j++)
        s->p[j] = last[j].d_p + (last[j].moved ? d_x : 0);
    return d_x;
}

static void play_tangent(const void *constants, const void *state, real x,
                         const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                         int count, real *restrict d_state, real *restrict row)
{
    const struct play *play = constants;
    real input[STAGE_CHUNK];

    (void)around, (void)d_around;
    for (int first = 0; first < count; first += STAGE_CHUNK) {
        const int n = count - first < STAGE_CHUNK ? count - first : STAGE_CHUNK;
        real *restrict output = row + first;
        memcpy(input, output, (size_t)n * sizeof *input);
        for (int j = 0; j < play->count; j++) {
            const real weight = play->element[j].weight;
            real *restrict p = d_state + (ptrdiff_t)j * count + first;
            if (play_moves(play, state, j, x))
                memcpy(p, input, (size_t)n * sizeof *input);
            for (int c = 0; c < n; c++)
                output[c] += weight * p[c];
        }
    }
}

static real play_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                               const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct play *play = constants, *d = d_constants;
    const struct play_state *s = state;
    real d_h = 0;

    (void)around;
    for (int j = d->first; j < d->count; j++) {
        const real r = play->element[j].threshold;
        const real moved = (real)-play_moves(play, s, j, x) * d->element[j].threshold;
        d_state[(ptrdiff_t)j * stride] += moved;
        d_h += play->element[j].weight * moved + d->element[j].weight * clamp(s->p[j], x - r, x + r);
    }
    return d_h;
}

static real play_inverse_tangent(const void *constants, const void *state, real x, void *d_state, real d_h,
                                 const struct stage_surroundings *around,
                                 const struct stage_surroundings *d_around)
{
    const struct play *play = constants;
    const struct play_state *d = d_state;
    real slope = 1;

    (void)around, (void)d_around;
    for (int j = 0; j < play->count; j++) {
        if (play_moves(play, state, j, x))
            slope += play->element[j].weight;
        else
            d_h -= play->element[j].weight * d->p[j];
    }
    return d_h / slope;
}

const struct stage play_stage = {
    .is_on = play_is_on,
    .is_idle = play_is_idle,
    .prepare = play_prepare,
    .rest = play_rest,
    .step = play_step,
    .used = play_used,
    .inverse = play_inverse,
};

const struct stage_analysis play_analysis = {
    .check = play_check,
    .prepare_tangent = play_prepare_tangent,
    .rest_tangent = play_rest_tangent,
    .tangent = play_tangent,
    .by_parameters = play_by_parameters,
    .inverse_tangent = play_inverse_tangent,
};

/* --- resonance.c --- */

/* A slower pair of poles would leave too few digits in 1 - a1 - a2. */
#define RESONANCE_SLOWEST REAL(1e-5) /* per sample time */
/* Nearer to -1 the inverse would ring for long. */
#define RESONANCE_LOWEST_ZERO REAL(-0.95)
/* A delay that is the longest but for rounding is taken as that. */
#define RESONANCE_ROUNDING REAL(1e-9)

static bool resonance_check(const struct chain_parameters *p, char *message, size_t size)
{
    const real frequency = p->resonance.frequency, damping = p->resonance.damping;
    const real sample_time = p->sampleTime;

    if (frequency == 0)
        return true;
    if (!(frequency >= RESONANCE_SLOWEST / sample_time && frequency < REAL(0.5) / sample_time))
        return refuse(message, size,
                      "resonance.frequency is %g Hz; at a sampleTime of %g s it must be "
                      "%g Hz to below %g Hz (Nyquist), or 0 for none",
                      (double)frequency, (double)sample_time, (double)(RESONANCE_SLOWEST / sample_time),
                      (double)(REAL(0.5) / sample_time));
    if (!(damping > 0 && damping < 1))
        return refuse(message, size, "resonance.damping is %g; it must be above 0 and below 1",
                      (double)damping);
    if (!(p->resonance.samplingZero >= RESONANCE_LOWEST_ZERO && p->resonance.samplingZero <= 0))
        return refuse(message, size, "resonance.samplingZero is %g; it must be %g to 0",
                      (double)p->resonance.samplingZero, (double)RESONANCE_LOWEST_ZERO);
    const real longest = RESONANCE_MAX_TICKS * sample_time;
    if (!(p->resonance.samplingDelay >= 0 && p->resonance.samplingDelay <= longest * (1 + RESONANCE_ROUNDING)))
        return refuse(message, size,
                      "resonance.samplingDelay is %g s; at a sampleTime of %g s it must be 0 to %g s, %d ticks",
                      (double)p->resonance.samplingDelay, (double)sample_time, (double)longest,
                      RESONANCE_MAX_TICKS);
    return true;
}

static bool resonance_is_on(const struct chain_parameters *p)
{
    return p->resonance.frequency > 0;
}

static void resonance_prepare(void *constants, const struct chain_parameters *p)
{
    const real angle = TWO_PI * p->resonance.frequency * p->sampleTime;
    const real damping = p->resonance.damping;
    const real radius = real_exp(-damping * angle);
    struct resonance *resonance = constants;

    resonance->a1 = 2 * radius * real_cos(angle * real_sqrt(1 - damping * damping));
    resonance->a2 = -radius * radius;
    resonance->b0 = (1 - resonance->a1 - resonance->a2) / (1 - p->resonance.samplingZero);
    resonance->b1 = -p->resonance.samplingZero * resonance->b0;
    resonance->per_b0 = 1 / resonance->b0;
    resonance->latency = p->resonance.samplingDelay;
    resonance->ticks = real_fmin(resonance->latency / p->sampleTime, RESONANCE_MAX_TICKS);
}

static real resonance_latency(const void *constants)
{
    const struct resonance *resonance = constants;

    return resonance->latency;
}

static void resonance_advance(struct resonance_state *state, real x, real y)
{
    state->y2 = state->y1;
    state->y1 = y;
    state->x1 = x;
}

/* What y was so many ticks ago. */
static real resonance_before(real ticks, real y, real y1, real y2)
{
    return ticks > 1 ? y1 + (ticks - 1) * (y2 - y1) : y + ticks * (y1 - y);
}

static real resonance_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct resonance *resonance = constants;
    struct resonance_state *s = state;
    const real y = resonance->a1 * s->y1 + resonance->a2 * s->y2 + resonance->b0 * x + resonance->b1 * s->x1;
    const real later = resonance->ticks > 0 ? resonance_before(resonance->ticks, y, s->y1, s->y2) : y;

    (void)around;
    resonance_advance(s, x, y);
    return later;
}

static real resonance_inverse(const void *constants, void *state, real y,
                              const struct stage_surroundings *around)
{
    const struct resonance *resonance = constants;
    struct resonance_state *s = state;
    const real past = resonance->a1 * s->y1 + resonance->a2 * s->y2 + resonance->b1 * s->x1;
    const real x = (y - past) * resonance->per_b0;

    (void)around;
    resonance_advance(s, x, y);
    return x;
}

static void resonance_prepare_tangent(void *d_constants, const void *constants,
                                      const struct chain_parameters *p, const struct chain_parameters *d)
{
    const real damping = p->resonance.damping, d_damping = d->resonance.damping;
    const real angle = TWO_PI * p->resonance.frequency * p->sampleTime;
    const real d_angle = TWO_PI * d->resonance.frequency * p->sampleTime;
    const real radius = real_exp(-damping * angle);
    const real d_radius = -radius * (d_damping * angle + damping * d_angle);
    const real root = real_sqrt(1 - damping * damping);
    const real d_phase = d_angle * root - angle * damping / root * d_damping;
    const struct resonance *at = constants;
    struct resonance *result = d_constants;

    result->a1 = 2 * (d_radius * real_cos(angle * root) - radius * real_sin(angle * root) * d_phase);
    result->a2 = -2 * radius * d_radius;
    const real past = 1 - p->resonance.samplingZero;
    result->b0 = (-result->a1 - result->a2 + at->b0 * d->resonance.samplingZero) / past;
    result->b1 = -d->resonance.samplingZero * at->b0 - p->resonance.samplingZero * result->b0;
    result->latency = d->resonance.samplingDelay;
    result->ticks = d->resonance.samplingDelay / p->sampleTime;
}

static void resonance_tangent(const void *constants, const void *state, real x,
                              const struct stage_surroundings *around,
                              const struct stage_surroundings *d_around, int count, real *restrict d_state,
                              real *restrict row)
{
    const struct resonance *resonance = constants;
    real *restrict d_y2 = d_state + count;
    real *restrict d_x1 = d_state + 2 * count;

    (void)around, (void)state, (void)x, (void)d_around;
    for (int c = 0; c < count; c++) {
        const real d_y1 = d_state[c], d_before = d_y2[c];
        const real d_y =
            resonance->a1 * d_y1 + resonance->a2 * d_before + resonance->b0 * row[c] + resonance->b1 * d_x1[c];
        d_y2[c] = d_y1;
        d_x1[c] = row[c];
        d_state[c] = d_y;
        row[c] = resonance_before(resonance->ticks, d_y, d_y1, d_before);
    }
}

/* Of `resonance_before` by the ticks; at a whole one, where it has a corner, the mean of both sides. */
static real resonance_by_ticks(real ticks, real y, real y1, real y2)
{
    if (ticks == 1)
        return REAL(0.5) * (y2 - y);
    return ticks > 1 ? y2 - y1 : y1 - y;
}

static real resonance_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                                    const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct resonance *resonance = constants, *d = d_constants;
    const struct resonance_state *s = state;
    const real moved = d->a1 * s->y1 + d->a2 * s->y2 + d->b0 * x + d->b1 * s->x1;
    const real ticks = resonance->ticks;

    (void)around, (void)stride;
    d_state[0] += moved;
    const real later = resonance_before(ticks, moved, 0, 0);
    if (d->ticks == 0)
        return later;
    const real y = resonance->a1 * s->y1 + resonance->a2 * s->y2 + resonance->b0 * x + resonance->b1 * s->x1;
    return later + d->ticks * resonance_by_ticks(ticks, y, s->y1, s->y2);
}

static real resonance_inverse_tangent(const void *constants, const void *state, real x, void *d_state, real d_y,
                                      const struct stage_surroundings *around,
                                      const struct stage_surroundings *d_around)
{
    (void)around, (void)state, (void)x;
    return resonance_inverse(constants, d_state, d_y, d_around); /* it is linear */
}

const struct stage resonance_stage = {
    .is_on = resonance_is_on,
    .prepare = resonance_prepare,
    .step = resonance_step,
    .inverse = resonance_inverse,
    .latency = resonance_latency,
};

const struct stage_analysis resonance_analysis = {
    .check = resonance_check,
    .prepare_tangent = resonance_prepare_tangent,
    .tangent = resonance_tangent,
    .by_parameters = resonance_by_parameters,
    .inverse_tangent = resonance_inverse_tangent,
};

/* --- saturation.c --- */

static bool saturation_check(const struct chain_parameters *p, char *message, size_t size)
{
    const struct saturation_parameters *limits = &p->saturation;

    if (limits->minimum == 0 && limits->maximum == 0)
        return true;
    if (!(limits->minimum < limits->maximum))
        return refuse(message, size,
                      "saturation.minimum, %g V, must be below saturation.maximum, %g V "
                      "(both 0: no saturation)",
                      (double)limits->minimum, (double)limits->maximum);
    return true;
}

static bool saturation_is_on(const struct chain_parameters *p)
{
    return p->saturation.minimum < p->saturation.maximum;
}

static void saturation_prepare(void *constants, const struct chain_parameters *p)
{
    *(struct saturation *)constants = (struct saturation){ p->saturation.minimum, p->saturation.maximum };
}

static real saturation_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct saturation *limits = constants;

    (void)state, (void)around;
    return clamp(x, limits->minimum, limits->maximum);
}

static void saturation_tangent(const void *constants, const void *state, real x,
                               const struct stage_surroundings *around,
                               const struct stage_surroundings *d_around, int count, real *restrict d_state,
                               real *restrict row)
{
    const struct saturation *limits = constants;

    (void)around, (void)state, (void)d_around, (void)d_state;
    if (!(x < limits->minimum || x > limits->maximum))
        return;
    for (int c = 0; c < count; c++)
        row[c] = 0;
}

static real saturation_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                                     const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct saturation *limits = constants, *d = d_constants;

    (void)state, (void)around, (void)d_state, (void)stride;
    return x < limits->minimum ? d->minimum : x > limits->maximum ? d->maximum : 0;
}

const struct stage saturation_stage = {
    .limits = true,
    .is_on = saturation_is_on,
    .prepare = saturation_prepare,
    .step = saturation_step,
    .inverse = saturation_step,
};

const struct stage_analysis saturation_analysis = {
    .check = saturation_check,
    .tangent = saturation_tangent,
    .by_parameters = saturation_by_parameters,
};

/* --- slew.c --- */

static bool slew_check(const struct chain_parameters *p, char *message, size_t size)
{
    if (!(p->slew.rate >= 0))
        return refuse(message, size, "slew.rate is %g V/s; it must be positive, or 0 for no limit",
                      (double)p->slew.rate);
    return true;
}

static bool slew_is_on(const struct chain_parameters *p)
{
    return p->slew.rate > 0;
}

static void slew_prepare(void *constants, const struct chain_parameters *p)
{
    struct slew *slew = constants;

    slew->step = p->slew.rate * p->sampleTime;
}

static real slew_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct slew *slew = constants;
    struct slew_state *s = state;

    (void)around;
    s->y = clamp(x, s->y - slew->step, s->y + slew->step);
    return s->y;
}

static void slew_prepare_tangent(void *d_constants, const void *constants, const struct chain_parameters *p,
                                 const struct chain_parameters *d)
{
    struct slew *result = d_constants;

    (void)constants;
    result->step = d->slew.rate * p->sampleTime;
}

/* 1 above what it lets through, -1 below, 0 within. */
static int slew_limited(const struct slew *slew, const struct slew_state *s, real x)
{
    return (x > s->y + slew->step) - (x < s->y - slew->step);
}

static void slew_tangent(const void *constants, const void *state, real x,
                         const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                         int count, real *restrict d_state, real *restrict row)
{
    const bool limited = slew_limited(constants, state, x) != 0;

    (void)around, (void)d_around;
    for (int c = 0; c < count; c++)
        row[c] = d_state[c] = limited ? d_state[c] : row[c];
}

static real slew_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                               const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct slew *d = d_constants;
    const real moved = (real)slew_limited(constants, state, x) * d->step;

    (void)around, (void)stride;
    d_state[0] += moved;
    return moved;
}

const struct stage slew_stage = {
    .limits = true,
    .is_on = slew_is_on,
    .prepare = slew_prepare,
    .step = slew_step,
    .inverse = slew_step,
};

const struct stage_analysis slew_analysis = {
    .check = slew_check,
    .prepare_tangent = slew_prepare_tangent,
    .tangent = slew_tangent,
    .by_parameters = slew_by_parameters,
};

/* --- fmu_lifecycle.c --- */

/* loggingOn is for debugging. What comes with a status is logged also without it: the standard says of
 * fmi2Warning that the logger was called, and a host that never asked still wants the reason of an error. */
enum { QUIET_CATEGORIES = FMU_LOG_WARNING | FMU_LOG_DISCARD | FMU_LOG_ERROR };

static void begin(struct fmu *fmu)
{
    const struct fmu_model *model = fmu->model;

    fmu_gather(fmu);
    memset(fmu->now, 0, fmu_snapshot_size(model));
    memset(fmu->before, 0, model->state_size);
    fmu->now->phase = FMU_INSTANTIATED;
    fmu->now->clock.stop_time = INFINITY;
    memcpy(fmu->parameters, fmu->start, model->parameters_size);
    memcpy(fmu->now->input, model->input_start, sizeof model->input_start);
    fmu_note_ramps(fmu);
    fmu->outputs_stale = true;
}

static size_t whole_words(size_t size)
{
    return (size + 7) / 8 * 8;
}

/* The next `size` bytes of an instance's memory. */
static void *take(char **memory, size_t size)
{
    void *taken = *memory;

    *memory += whole_words(size);
    return taken;
}

static size_t port_of(const struct fmu_variable *v)
{
    if (!v || v->causality == FMU_PARAMETER)
        return FMU_NO_PORT;
    if (v->causality == FMU_INPUT)
        return v->offset / sizeof(double);
    if (v->base == FMU_REAL)
        return FMU_REAL_PORT + (v->offset - offsetof(struct fmu_outputs, real)) / sizeof(double);
    return FMU_FLAG_PORT + (v->offset - offsetof(struct fmu_outputs, flag)) / sizeof(int);
}

struct fmu *fmu_create(const struct fmu_model *model, const char *name, const void *parameters,
                       const struct fmu_host *host, bool logging)
{
    const size_t block = fmu_snapshot_size(model);
    const size_t name_size = strlen(name) + 1;
    const size_t rest = whole_words(model->constants_size) + 2 * model->parameters_size + 2 * model->state_size;
    struct fmu *fmu = calloc(1, sizeof *fmu + block + rest + name_size);

    if (!fmu)
        return NULL;
    char *memory = (char *)(fmu->now + 1);
    fmu->model = model;
    fmu->parameters = take(&memory, model->parameters_size);
    fmu->state = take(&memory, model->state_size);
    fmu->last_state = take(&memory, model->state_size);
    fmu->constants = take(&memory, model->constants_size);
    fmu->before = take(&memory, model->state_size);
    fmu->d_state = take(&memory, model->state_size);
    fmu->d_parameters = take(&memory, model->parameters_size);
    fmu->start = take(&memory, model->parameters_size);
    memcpy(fmu->start, parameters, model->parameters_size);
    fmu->name = memcpy(memory, name, name_size);
    fmu->used = model->state_size;
    for (unsigned i = 0; i < FMU_PORTS; i++)
        fmu->port[i] = (unsigned char)port_of(fmu_find(model, i));
    fmu->host = *host;
    fmu->categories = logging ? FMU_LOG_ALL : QUIET_CATEGORIES;
    begin(fmu);
    return fmu;
}

/* {01234567-89ab-cdef-0123-456789abcdef} as two numbers. */
static bool read_token(const char *token, uint64_t half[2])
{
    int digits = 0;

    half[0] = half[1] = 0;
    for (; *token; token++) {
        if (isxdigit((unsigned char)*token) && digits < 32) {
            const int c = tolower((unsigned char)*token);
            half[digits / 16] = half[digits / 16] << 4 | (uint64_t)(c <= '9' ? c - '0' : c - 'a' + 10);
            digits++;
        } else if (*token != '{' && *token != '}' && *token != '-')
            return false;
    }
    return digits == 32;
}

static bool find_set(const struct fmu_model *model, const struct fmu_set *compiled_in, const char *token,
                     const char *resources, void *parameters, char *message, size_t size)
{
    uint64_t half[2];

    if (!read_token(token, half) || half[0] != model->table_hash ||
        (half[1] != compiled_in->hash && !compiled_in->find)) {
        snprintf(message, size,
                 "the GUID '%.64s' is not that of a modelDescription.xml for this binary "
                 "of %s.",
                 token, model->identifier);
        return false;
    }
    if (half[1] != compiled_in->hash)
        return compiled_in->find(model, half[1], resources, parameters, message, size);
    memcpy(parameters, compiled_in->parameters, model->parameters_size);
    return true;
}

struct fmu *fmu_instantiate(const struct fmu_model *model, const struct fmu_set *compiled_in,
                            const char *function, const char *name, const char *token, const char *resources,
                            const struct fmu_host *host, bool logging)
{
    char message[1024], text[1100];
    struct fmu *fmu = NULL;

    if (!name || !*name || !token) {
        snprintf(text, sizeof text, "%s: an instance needs a name and a GUID.", function);
        fmu_say_early(host, "", text);
        return NULL;
    }
    void *parameters = malloc(model->parameters_size);
    if (!parameters)
        return NULL;
    if (find_set(model, compiled_in, token, resources, parameters, message, sizeof message))
        fmu = fmu_create(model, name, parameters, host, logging);
    else {
        snprintf(text, sizeof text, "%s: %s", function, message);
        fmu_say_early(host, name, text);
    }
    free(parameters);
    if (fmu)
        fmu_say(fmu, FMU_OK, "instantiated %s.", model->identifier);
    return fmu;
}

void fmu_free(struct fmu *fmu)
{
    free(fmu);
}

enum fmu_status fmu_setup(struct fmu *fmu, const char *function, bool tolerance_defined, double tolerance,
                          double start_time, bool stop_time_defined, double stop_time)
{
    struct fmu_clock clock = { 0 };
    char message[128];

    if (!fmu_may(fmu, function, FMU_INSTANTIATED))
        return FMU_ERROR;
    if (!fmu_clock_setup(&clock, start_time, stop_time_defined, stop_time, message, sizeof message))
        return fmu_say(fmu, FMU_ERROR, "%s: %s.", function, message);
    /* a discrete model has no error to control: a tolerance has nothing to act on */
    if (tolerance_defined && !(isfinite(tolerance) && tolerance >= 0.0))
        return fmu_say(fmu, FMU_ERROR, "%s: tolerance, %g, must not be negative.", function, tolerance);
    fmu->now->clock = clock;
    return FMU_OK;
}

enum fmu_status fmu_enter_initialization(struct fmu *fmu, const char *function)
{
    if (!fmu_may(fmu, function, FMU_INSTANTIATED))
        return FMU_ERROR;
    fmu->now->phase = FMU_INITIALIZATION;
    fmu->outputs_stale = true;
    return FMU_OK;
}

enum fmu_status fmu_compute_start_outputs(struct fmu *fmu, const char *function)
{
    const struct fmu_model *model = fmu->model;
    struct fmu_outputs output = fmu->now->output;
    char message[512];

    if (!model->check(model, fmu->parameters, message, sizeof message))
        return fmu_say(fmu, FMU_ERROR, "%s: %s.", function, message);
    fmu->used = model->prepare(fmu->constants, fmu->parameters);
    if (!model->start(fmu->constants, fmu->before, fmu->parameters, &output, message, sizeof message))
        return fmu_say(fmu, FMU_ERROR, "%s: %s.", function, message);
    memcpy(fmu->state, fmu->before, model->state_size);
    memcpy(fmu->before, fmu->last_state, model->state_size);
    fmu->now->output = output;
    fmu->outputs_stale = false;
    return FMU_OK;
}

enum fmu_status fmu_exit_initialization(struct fmu *fmu, const char *function)
{
    if (!fmu_may(fmu, function, FMU_INITIALIZATION) || fmu_start_outputs(fmu, function) != FMU_OK)
        return FMU_ERROR;
    fmu_settle(fmu);
    fmu_clock_start(&fmu->now->clock, fmu_sample_time(fmu));
    fmu->now->phase = FMU_STEP_COMPLETE;
    return FMU_OK;
}

enum fmu_status fmu_terminate(struct fmu *fmu, const char *function)
{
    if (!fmu_may(fmu, function, FMU_STEP_COMPLETE))
        return FMU_ERROR;
    fmu_leave_plain(fmu);
    fmu->now->phase = FMU_TERMINATED;
    return FMU_OK;
}

enum fmu_status fmu_reset(struct fmu *fmu, const char *function)
{
    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    begin(fmu);
    return FMU_OK;
}

/* --- fmu_variables.c --- */

static const char *const BASE_NAME[] = { "Real", "Integer", "Boolean", "String" };

const struct fmu_variable *fmu_find_parameter(const struct fmu_model *model, const char *name, size_t length)
{
    for (unsigned i = 0; i < model->rows; i++) {
        const struct fmu_variable *v = fmu_find(model, i);
        if (v && v->causality == FMU_PARAMETER && strlen(v->name) == length &&
            memcmp(v->name, name, length) == 0)
            return v;
    }
    return NULL;
}

static void *at(const struct fmu *fmu, const struct fmu_variable *variable)
{
    char *const base = variable->causality == FMU_OUTPUT  ? (char *)&fmu->now->output
                       : variable->causality == FMU_INPUT ? (char *)fmu->now->input
                                                          : (char *)fmu->parameters;

    return base + variable->offset;
}

static int integer(const void *parameters, size_t offset)
{
    return *(const int *)((const char *)parameters + offset);
}

static double real_at(const void *parameters, size_t offset)
{
    return *(const double *)((const char *)parameters + offset);
}

/* Elements of a group beyond its count are in the table but not in use. */
static bool in_use(const struct fmu_variable *variable, const void *parameters)
{
    return variable->index == 0 || variable->index <= integer(parameters, variable->count);
}

bool fmu_within_bounds(const struct fmu_model *model, const void *parameters, char *message, size_t size)
{
    for (unsigned i = 0; i < model->rows; i++) {
        const struct fmu_variable *v = fmu_find(model, i);
        if (!v || v->causality != FMU_PARAMETER || !in_use(v, parameters))
            continue;
        const double value =
            v->base == FMU_REAL ? real_at(parameters, v->offset) : integer(parameters, v->offset);
        if (!(value >= v->minimum && value <= v->maximum)) {
            snprintf(message, size, "%s is %g; it must be %g to %g", v->name, value, v->minimum, v->maximum);
            return false;
        }
    }
    return true;
}

/* An Integer is the number of rules, play operators or creep terms: as many as the set that the FMU was
 * packaged with has, or fewer. Of more the XML lists nothing, unless it lists arrays. */
static bool count_possible(const struct fmu *fmu, const struct fmu_variable *variable, int count, char *message,
                           size_t size)
{
    const int most = fmu->host.resizes ? (int)variable->maximum : integer(fmu->start, variable->offset);

    if (count >= variable->minimum && count <= most)
        return true;
    if (count > most && most < variable->maximum)
        snprintf(message, size,
                 "%s is %d, but this FMU was packaged with %d; for more, package a parameter "
                 "set that has more (it2hys package)",
                 variable->name, count, most);
    else
        snprintf(message, size, "%s is %d; it must be %g to %d", variable->name, count, variable->minimum,
                 most);
    return false;
}

static bool outputs_possible(const struct fmu_outputs *output)
{
    bool possible = true;

    for (int i = 0; i < FMU_REAL_OUTPUTS; i++)
        possible &= isfinite(output->real[i]) != 0;
    for (int i = 0; i < FMU_FLAGS; i++)
        possible &= (unsigned)output->flag[i] <= 1u;
    return possible;
}

bool fmu_values_possible(const struct fmu *fmu, const struct fmu_snapshot *snapshot, const void *parameters,
                         char *message, size_t size)
{
    for (unsigned i = 0; i < fmu->model->rows; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, i);
        if (!v || v->causality != FMU_PARAMETER)
            continue;
        if (v->base == FMU_INTEGER && !count_possible(fmu, v, integer(parameters, v->offset), message, size))
            return false;
        if (v->base == FMU_REAL && !isfinite(real_at(parameters, v->offset))) {
            snprintf(message, size, "%s has no finite value", v->name);
            return false;
        }
    }
    if (outputs_possible(&snapshot->output))
        return true;
    snprintf(message, size, "an output has no finite value");
    return false;
}

/* The variable behind a reference, if it is one of the right type; otherwise says why not. */
static const struct fmu_variable *lookup(const struct fmu *fmu, const char *function, enum fmu_base base,
                                         unsigned reference)
{
    const struct fmu_variable *variable = fmu_find(fmu->model, reference);

    if (!variable) {
        fmu_say(fmu, FMU_ERROR, "%s: %s has no variable with the value reference %u.", function,
                fmu->model->identifier, reference);
        return NULL;
    }
    if (variable->base != base) {
        fmu_say(fmu, FMU_ERROR, "%s: variable %s is of type %s, not %s.", function, variable->name,
                BASE_NAME[variable->base], BASE_NAME[base]);
        return NULL;
    }
    return variable;
}

/* The variable behind a reference that lookup has accepted. */
static const struct fmu_variable *accepted(const struct fmu *fmu, unsigned reference)
{
    return &fmu->model->table[reference];
}

bool fmu_null_arrays(const struct fmu *fmu, const char *function, const void *references, const void *values,
                     size_t count)
{
    if (count == 0 || (references && values))
        return false;
    fmu_say(fmu, FMU_ERROR, "%s: an array is a null pointer.", function);
    return true;
}

enum fmu_status fmu_get(struct fmu *fmu, const char *function, enum fmu_base base, const unsigned references[],
                        size_t count, void *values)
{
    if (!fmu_may(fmu, function, FMU_INITIALIZATION | FMU_INITIALIZED | (fmu ? fmu->host.reads : 0)) ||
        fmu_null_arrays(fmu, function, references, values, count))
        return FMU_ERROR;
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = lookup(fmu, function, base, references[i]);
        if (!v)
            return FMU_ERROR;
        if (v->causality == FMU_OUTPUT && fmu_start_outputs(fmu, function) != FMU_OK)
            return FMU_ERROR;
        if (base == FMU_REAL)
            ((double *)values)[i] = *(double *)at(fmu, v);
        else
            ((int *)values)[i] = *(int *)at(fmu, v);
    }
    return FMU_OK;
}

/* May this variable be set now? Otherwise says why not. */
static bool settable(const struct fmu *fmu, const char *function, const struct fmu_variable *variable)
{
    if (variable->causality == FMU_OUTPUT) {
        fmu_say(fmu, FMU_ERROR, "%s: %s is an output; it cannot be set.", function, variable->name);
        return false;
    }
    if (variable->causality == FMU_PARAMETER && fmu->now->phase & FMU_INITIALIZED) {
        fmu_say(fmu, FMU_ERROR, "%s: %s is a fixed parameter; set it before initialization ends.", function,
                variable->name);
        return false;
    }
    const bool structural = variable->base == FMU_INTEGER && fmu->host.resizes;
    if (structural == (fmu->now->phase == FMU_CONFIGURATION))
        return true;
    fmu_say(fmu, FMU_ERROR, "%s: %s is %s structural parameter; these alone are set in configurationMode.",
            function, variable->name, structural ? "a" : "no");
    return false;
}

enum fmu_status fmu_set(struct fmu *fmu, const char *function, enum fmu_base base, const unsigned references[],
                        size_t count, const void *values)
{
    char message[256];

    if (!fmu_may(fmu, function,
                 FMU_INSTANTIATED | FMU_CONFIGURATION | FMU_INITIALIZATION | FMU_STEP_COMPLETE | FMU_UPDATE) ||
        fmu_null_arrays(fmu, function, references, values, count))
        return FMU_ERROR;
    for (size_t i = 0; i < count; i++) { /* all are checked before any is set */
        const struct fmu_variable *v = lookup(fmu, function, base, references[i]);
        if (!v || !settable(fmu, function, v))
            return FMU_ERROR;
        if (base == FMU_REAL && !isfinite(((const double *)values)[i]))
            return fmu_say(fmu, FMU_DISCARD, "%s: %s must be a finite number, not %g; it keeps its last value.",
                           function, v->name, ((const double *)values)[i]);
        if (base == FMU_INTEGER && !count_possible(fmu, v, ((const int *)values)[i], message, sizeof message))
            return fmu_say(fmu, FMU_ERROR, "%s: %s.", function, message);
    }
    for (size_t i = 0; i < count; i++) {
        void *target = at(fmu, accepted(fmu, references[i]));
        if (base == FMU_REAL)
            *(double *)target = ((const double *)values)[i];
        else
            *(int *)target = ((const int *)values)[i];
    }
    fmu->outputs_stale |= !(fmu->now->phase & FMU_INITIALIZED);
    return FMU_OK;
}

enum fmu_status fmu_set_input_derivatives(struct fmu *fmu, const char *function, const unsigned references[],
                                          size_t count, const int order[], const double values[])
{
    if (!fmu_may(fmu, function, FMU_INSTANTIATED | FMU_INITIALIZATION | FMU_STEP_COMPLETE))
        return FMU_ERROR;
    if (!fmu->model->interpolates)
        return fmu_lacks(fmu, function);
    if (fmu_null_arrays(fmu, function, references, values, count) ||
        fmu_null_arrays(fmu, function, references, order, count))
        return FMU_ERROR;
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = lookup(fmu, function, FMU_REAL, references[i]);
        if (!v)
            return FMU_ERROR;
        if (v->causality != FMU_INPUT)
            return fmu_say(fmu, FMU_ERROR, "%s: %s is not an input.", function, v->name);
        if (order[i] != 1)
            return fmu_say(fmu, FMU_ERROR,
                           "%s: order %d of %s; inputs are interpolated linearly, from order 1 only.", function,
                           order[i], v->name);
        if (!isfinite(values[i]))
            return fmu_say(fmu, FMU_DISCARD,
                           "%s: the derivative of %s must be a finite number, not %g; it keeps its "
                           "last value.",
                           function, v->name, values[i]);
    }
    for (size_t i = 0; i < count; i++)
        *(double *)((char *)fmu->now->slope + accepted(fmu, references[i])->offset) = values[i];
    fmu_note_ramps(fmu);
    return FMU_OK;
}

/* --- fmu_step.c --- */

/* doStep. Which ticks a step has is the clock's (fmu_clock.h); each runs with the input at its own time, and
 * outputs hold their value from tick to tick. */

/* --- fmu_plain.h --- */

/* Plain steps (struct fmu_plain), as most are: what any step does, in short, and in the very function that a host
 * calls. Everything else is in fmu_step.c. */

HIDDEN_BEGIN

void fmu_copy_state(void *to, const void *from, size_t used);

/* Ends a step of one tick that has findings, which may have been logged before. */
enum fmu_status fmu_finish_with_findings(struct fmu *fmu, const char *function, double time, double step,
                                         unsigned findings);

/* A step that is not plain, or not known to be. */
enum fmu_status fmu_other_step(struct fmu *fmu, const char *function, double time, double step);

/* What directional derivatives repeat of every step: the state that it began with, */
static inline void fmu_note_state(struct fmu *fmu)
{
    void *last_state = fmu->last_state;

    fmu->last_state = fmu->before;
    fmu->before = last_state;
}

/* and its inputs. */
static inline void fmu_note_input(struct fmu_snapshot *now)
{
    const volatile double *input = now->input; /* one by one: as fmu_copy_state */

    for (int i = 0; i < FMU_INPUTS; i++)
        now->last_step.input[i] = input[i];
}

static inline enum fmu_status fmu_finish_tick(struct fmu_snapshot *now, enum fmu_status status, double end)
{
    fmu_note_input(now);
    fmu_clock_tick(&now->clock, end);
    return status;
}

/* From one tick to the next under constant inputs, */
static inline enum fmu_status fmu_one_tick(struct fmu *fmu, const char *function, double tick_time, double time,
                                           double step)
{
    struct fmu_snapshot *now = fmu->now;

    fmu_copy_state(fmu->before, fmu->state, fmu->used);
    const unsigned findings =
        fmu->tick(fmu->constants, fmu->state, fmu->parameters, now->input, tick_time, &now->output);
    if (!USUALLY(findings == 0))
        return fmu_finish_with_findings(fmu, function, time, step, findings);
    fmu_note_state(fmu);
    return fmu_finish_tick(now, FMU_OK, time + step);
}

/* and where the state is a single number, as most often: kept in a register, it saves a twentieth of what the layer
 * takes (measured). */
static inline enum fmu_status fmu_one_tick_of_one(struct fmu *fmu, const char *function, double tick_time,
                                                  double time, double step)
{
    struct fmu_snapshot *now = fmu->now;
    const double number = *(const double *)fmu->state, end = time + step;
    const unsigned findings =
        fmu->tick(fmu->constants, fmu->state, fmu->parameters, now->input, tick_time, &now->output);

    if (!USUALLY(findings == 0)) {
        *(double *)fmu->before = number;
        return fmu_finish_with_findings(fmu, function, time, step, findings);
    }
    *(double *)fmu->last_state = number;
    return fmu_finish_tick(now, FMU_OK, end);
}

/* Of what fmu_clock_is_tick asks that is left which a plain step can change. */
static inline bool fmu_is_plain(const struct fmu_plain *plain, double tick_time, double time, double step)
{
    return fabs(time - tick_time) <= plain->off && time + step <= plain->end;
}

/* fmu_do_step, where it is called. */
static inline enum fmu_status fmu_do_step_here(struct fmu *fmu, const char *function, double time, double step)
{
    if (USUALLY(fmu && step == fmu->plain.step)) {
        const double tick_time = (double)fmu->now->clock.tick * step;
        if (USUALLY(fmu_is_plain(&fmu->plain, tick_time, time, step)))
            return USUALLY(fmu->used == sizeof(double))
                       ? fmu_one_tick_of_one(fmu, function, tick_time, time, step)
                       : fmu_one_tick(fmu, function, tick_time, time, step);
    }
    return fmu_other_step(fmu, function, time, step);
}

HIDDEN_END

enum { FEW = 16 };

/* Of functions: what hardly ever happens is out of the way of what happens at every step, and what is rarest need not
 * even be fast. */
#if defined __GNUC__
#define RARE __attribute__((noinline))
#define RAREST __attribute__((noinline, cold))
#else
#define RARE
#define RAREST
#endif

void fmu_inputs_at(const struct fmu_span *span, int64_t tick, double sample_time, double input[FMU_INPUTS])
{
    const double elapsed = ((double)(tick - span->tick) - span->rest) * sample_time;

    for (int i = 0; i < FMU_INPUTS; i++)
        input[i] = span->input[i] + span->slope[i] * elapsed;
}

/* Copies what is in use of a state. A few numbers go one by one: a processor that reads two at a time what was just
 * written one by one waits until it is in memory. */
RARE void fmu_copy_state(void *to, const void *from, size_t used)
{
    if (used > FEW * sizeof(double)) {
        memcpy(to, from, used);
        return;
    }
    for (size_t i = 0; i < used; i += sizeof(double))
        memcpy((char *)to + i, (const char *)from + i, sizeof(double));
}

/* Logs what a tick is the first to find: each finding once in an instance's life, so that a log is not
 * flooded. */
static enum fmu_status warn(struct fmu *fmu, const char *function, unsigned findings, const double input[],
                            double time)
{
    char text[512];

    for (unsigned finding = 1; finding && finding <= findings; finding <<= 1) {
        if (!(findings & finding))
            continue;
        fmu->model->explain(finding, fmu->state, fmu->parameters, input, time, &fmu->now->output, text,
                            sizeof text);
        fmu_say(fmu, FMU_WARNING, "%s: %s This is logged once.", function, text);
    }
    fmu->now->warned |= findings;
    return FMU_WARNING;
}

/* Makes a status of a tick's findings. */
static void report(struct fmu *fmu, const char *function, unsigned findings, const double input[], double time,
                   enum fmu_status *status)
{
    const unsigned warned = (unsigned)fmu->now->warned;

    if (!(findings & ~warned))
        return;
    if (findings & FMU_NOT_FINITE)
        *status = FMU_DISCARD;
    else if (*status != FMU_DISCARD)
        *status = warn(fmu, function, findings & ~warned, input, time);
}

static inline void run_tick(struct fmu *fmu, const char *function, const double input[], double time,
                            enum fmu_status *status)
{
    const unsigned findings =
        fmu->model->tick(fmu->constants, fmu->state, fmu->parameters, input, time, &fmu->now->output);

    if (findings)
        report(fmu, function, findings, input, time, status);
}

static inline int64_t run_ticks(struct fmu *fmu, int64_t count)
{
    struct fmu_snapshot *now = fmu->now;

    return fmu->short_way ? fmu->model->ticks(fmu->constants, fmu->state, now->input, count, &now->output) : 0;
}

/* Runs the ticks up to `end_tick` in place. What a step of one tick costs is the way from the state of the
 * last tick to the next, and each copy between would lengthen it. */
static enum fmu_status run(struct fmu *fmu, const char *function, int64_t end_tick)
{
    struct fmu_snapshot *now = fmu->now;
    const int64_t first_tick = now->clock.next_tick;
    const double sample_time = fmu_sample_time(fmu);
    enum fmu_status status = FMU_OK;
    double input[FMU_INPUTS];

    if (!fmu->ramps) {
        for (int64_t tick = first_tick; tick < end_tick && status != FMU_DISCARD; tick++) {
            tick += run_ticks(fmu, end_tick - 1 - tick);
            run_tick(fmu, function, now->input, (double)tick * sample_time, &status);
        }
        return status;
    }
    struct fmu_span span = { .tick = now->clock.tick, .rest = now->clock.rest };
    memcpy(span.input, now->input, sizeof span.input);
    memcpy(span.slope, now->slope, sizeof span.slope);
    for (int64_t tick = first_tick; tick < end_tick && status != FMU_DISCARD; tick++) {
        fmu_inputs_at(&span, tick, sample_time, input);
        run_tick(fmu, function, input, (double)tick * sample_time, &status);
    }
    return status;
}

/* A step that is not made: everything stays as it was. */
static RARE enum fmu_status give_up(struct fmu *fmu, const char *function, double time, double step)
{
    fmu_copy_state(fmu->state, fmu->before, fmu->used);
    return fmu_say(
        fmu, FMU_DISCARD,
        "%s: the %s is no longer finite between %g s and %g s; the step is not made and the state is "
        "that of %g s.",
        function, fmu->model->diverging, time, time + step, time);
}

/* What directional derivatives repeat of a step that is not from a tick to the next under constant inputs. */
static void note_span(struct fmu_snapshot *now, int64_t end_tick)
{
    now->one_tick = false;
    now->last_step.tick = now->clock.tick;
    now->last_step.rest = now->clock.rest;
    now->last_step.first_tick = now->clock.next_tick;
    now->last_step.end_tick = end_tick;
    memcpy(now->last_step.slope, now->slope, sizeof now->slope);
}

struct fmu_span fmu_last_step(const struct fmu_snapshot *now)
{
    struct fmu_span last = now->last_step;

    if (now->one_tick) {
        last.tick = last.first_tick = now->clock.tick - 1;
        last.end_tick = now->clock.tick;
        last.rest = 0.0;
        memset(last.slope, 0, sizeof last.slope);
    }
    return last;
}

RARE enum fmu_status fmu_finish_with_findings(struct fmu *fmu, const char *function, double time, double step,
                                              unsigned findings)
{
    struct fmu_snapshot *now = fmu->now;
    enum fmu_status status = FMU_OK;

    report(fmu, function, findings, now->input, (double)now->clock.tick * fmu_sample_time(fmu), &status);
    if (status != FMU_OK)
        fmu_leave_plain(fmu);
    now->last_status = (int)status;
    if (status == FMU_DISCARD)
        return give_up(fmu, function, time, step);
    fmu_note_state(fmu);
    return fmu_finish_tick(now, status, time + step);
}

static RARE enum fmu_status any_step(struct fmu *fmu, const char *function, double time, double step)
{
    struct fmu_snapshot *now = fmu->now;
    const double sample_time = fmu_sample_time(fmu);
    const struct fmu_outputs held = now->output;
    const uint64_t warned = now->warned;
    struct fmu_clock end;
    char message[256];

    if (!fmu_clock_step(&now->clock, sample_time, time, step, &end))
        return fmu_say(fmu, FMU_ERROR, "%s: %s.", function,
                       fmu_clock_refusal(&now->clock, sample_time, time, step, message, sizeof message));
    fmu_copy_state(fmu->before, fmu->state, fmu->used);
    const enum fmu_status status = run(fmu, function, end.next_tick);
    now->last_status = (int)status;
    if (status == FMU_DISCARD) {
        now->output = held;
        now->warned = warned;
        return give_up(fmu, function, time, step);
    }
    fmu_note_state(fmu);
    fmu_note_input(now);
    note_span(now, end.next_tick);
    now->clock = end;
    return status;
}

/* Plain steps follow; their clock is far from where its ticks are no longer counted. */
static void expect_plain(struct fmu *fmu)
{
    const double sample_time = fmu_sample_time(fmu), stop_time = fmu->now->clock.stop_time;
    const double countable = 0.5 * CLOCK_LARGEST_TICK * sample_time;

    fmu->plain = (struct fmu_plain){ sample_time, CLOCK_TOLERANCE * sample_time,
                                     stop_time < countable ? stop_time : countable };
}

RAREST enum fmu_status fmu_other_step(struct fmu *fmu, const char *function, double time, double step)
{
    if (!fmu_may(fmu, function, FMU_STEP_COMPLETE))
        return FMU_ERROR;
    struct fmu_snapshot *now = fmu->now;
    const double sample_time = fmu_sample_time(fmu);
    fmu_leave_plain(fmu);
    if (fmu->ramps || !fmu_clock_is_tick(&now->clock, sample_time, time, step))
        return any_step(fmu, function, time, step);
    const enum fmu_status status =
        fmu_one_tick(fmu, function, (double)now->clock.tick * sample_time, time, step);
    if (status == FMU_DISCARD)
        return status;
    now->last_status = (int)status;
    now->one_tick = true;
    if (status == FMU_OK)
        expect_plain(fmu);
    return status;
}

EVERY_STEP enum fmu_status fmu_do_step(struct fmu *fmu, const char *function, double time, double step)
{
    return fmu_do_step_here(fmu, function, time, step);
}

/* --- fmu_update.c --- */

/* doStep for a host that sets inputs within it, or takes it that it ends early: the step is made in pieces of one
 * tick each, each of them a step. A host that does neither gets its step in one piece. */

/* A step in pieces. Tick k is at start + ((k - begin.tick) - begin.rest) sample times: by the host's time, which
 * need not be the ticks'. */
struct pieces {
    struct fmu *fmu;
    const char *function;
    double start;
    double end;
    struct fmu_clock begin;
    const void *begun; /* FMU state */
    bool updated;      /* the host was asked for inputs */
    enum fmu_status status;
};

static double time_of(const struct pieces *step, int64_t tick)
{
    const double ticks = (double)(tick - step->begin.tick) - step->begin.rest;

    return ticks > 0.0 ? step->start + ticks * fmu_sample_time(step->fmu) : step->start;
}

/* Goes on to `time`; false where it cannot. */
static bool go_to(struct pieces *step, double time)
{
    const double now = step->fmu->now->clock.time;

    if (time <= now)
        return true;
    const enum fmu_status status = fmu_do_step(step->fmu, step->function, now, time - now);

    if (status > step->status)
        step->status = status;
    return status <= FMU_WARNING;
}

/* Lets the host set inputs, and end the step sooner. */
static void ask_host(struct pieces *step)
{
    struct fmu *fmu = step->fmu;
    const double now = fmu->now->clock.time;
    double end = INFINITY;

    fmu_leave_plain(fmu);
    fmu->now->phase = FMU_UPDATE;
    const bool asked = fmu->host.update(&fmu->host, now, &end);
    fmu->now->phase = FMU_STEP_COMPLETE;
    step->updated = true;
    if (asked && fmu->host.ends_early && !(end >= step->end))
        step->end = end > now ? end : now; /* what is no number is now */
}

/* Is a flag true now that was not? */
static bool newly_outside(const struct fmu_outputs *before, const struct fmu_outputs *now)
{
    for (int i = 0; i < FMU_FLAGS; i++)
        if (now->flag[i] && !before->flag[i])
            return true;
    return false;
}

/* From tick to tick; returns whether all went well. */
static bool make_pieces(struct pieces *step)
{
    struct fmu *fmu = step->fmu;
    const double beginning = step->start + CLOCK_TOLERANCE * fmu_sample_time(fmu);

    for (int64_t tick = step->begin.next_tick; time_of(step, tick) < step->end; tick++) {
        const struct fmu_outputs before = fmu->now->output;
        const double time = time_of(step, tick);
        const double next = time_of(step, tick + 1);
        if (!go_to(step, time))
            return false;
        if (fmu->host.update && time > beginning) /* at the beginning, inputs were set before the step */
            ask_host(step);
        if (time >= step->end)
            return true;
        if (!go_to(step, next < step->end ? next : step->end))
            return false;
        if (fmu->host.ends_early && newly_outside(&before, &fmu->now->output))
            step->end = fmu->now->clock.time;
    }
    return go_to(step, step->end);
}

/* Derivatives are those of the whole step, where its inputs were the same throughout. */
static void join_pieces(const struct pieces *step)
{
    struct fmu *fmu = step->fmu;
    struct fmu_span last = fmu_last_step(fmu->now);

    last.tick = step->begin.tick;
    last.rest = step->begin.rest;
    last.first_tick = step->begin.next_tick;
    last.end_tick = fmu->now->clock.next_tick;
    fmu_leave_plain(fmu);
    fmu->now->last_step = last;
    fmu->now->one_tick = false;
    memcpy(fmu->last_state, fmu_state_in(fmu->model, step->begun), fmu->model->state_size);
    memcpy(fmu->before, fmu->last_state, fmu->model->state_size);
}

static enum fmu_status step_in_pieces(struct pieces *step, struct fmu_ending *ending)
{
    struct fmu *fmu = step->fmu;
    const double end = step->end;

    if (make_pieces(step)) {
        ending->early = step->end < end;
        if (!step->updated)
            join_pieces(step);
    } else if (fmu->host.ends_early && step->status == FMU_DISCARD && fmu->now->clock.time > step->start) {
        ending->early = ending->diverged = true; /* up to where it was finite */
        step->status = FMU_WARNING;
    } else {
        fmu_set_state(fmu, step->function, step->begun);
        fmu->now->last_status = (int)step->status;
        ending->diverged = step->status == FMU_DISCARD;
    }
    ending->time = step->status <= FMU_WARNING ? fmu->now->clock.time : step->start;
    return step->status;
}

/* Could the host's part make this step another one? It is asked at ticks behind the step's beginning only, and a
 * step with one tick cannot end sooner than it does. */
static bool has_pieces(struct pieces *step)
{
    const struct fmu *fmu = step->fmu;
    const struct fmu_clock *clock = &fmu->now->clock;
    const double sample_time = fmu_sample_time(fmu);
    struct fmu_clock end;

    if (fmu->now->phase != FMU_STEP_COMPLETE || !(fmu->host.update || fmu->host.ends_early) ||
        !fmu_clock_step(clock, sample_time, step->start, step->end - step->start, &end) ||
        !fmu_clock_step(clock, sample_time, step->start, 0.0, &step->begin))
        return false;
    const int64_t ticks = end.next_tick - step->begin.next_tick;
    return ticks > 1 || (ticks == 1 && fmu->host.update && time_of(step, step->begin.next_tick) > step->start);
}

enum fmu_status fmu_do_updated_step(struct fmu *fmu, const char *function, double time, double step,
                                    struct fmu_ending *ending)
{
    struct pieces pieces = { .fmu = fmu, .function = function, .start = time, .end = time + step };

    *ending = (struct fmu_ending){ .time = time };
    if (!fmu || !has_pieces(&pieces)) {
        const enum fmu_status status = fmu_do_step(fmu, function, time, step);
        if (status <= FMU_WARNING)
            ending->time = fmu->now->clock.time;
        ending->diverged = status == FMU_DISCARD;
        return status;
    }
    void *begun = NULL;
    if (fmu_get_state(fmu, function, &begun) != FMU_OK)
        return FMU_ERROR;
    fmu_leave_plain(fmu);
    fmu->now->clock = pieces.begin; /* and its time is the host's */
    pieces.begun = begun;
    const enum fmu_status status = step_in_pieces(&pieces, ending);
    free(begun);
    return status;
}

/* --- fmu_derivative.c --- */

/* Directional derivatives: of the outputs held now by the inputs that the last step ran with, and in
 * initialization by the parameters. */

/* A derivative repeats the ticks of the last step. */
#define LONGEST_DERIVATIVE 1000000

/* Adds seeds by value reference to derivatives of the inputs, and in initialization of the parameters. */
static bool collect_seeds(const struct fmu *fmu, const char *function, const unsigned knowns[], size_t count,
                          const double seeds[], bool starting, double d_input[FMU_INPUTS])
{
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, knowns[i]);
        const bool input = v && v->causality == FMU_INPUT;
        if (!v || v->base != FMU_REAL || !(input || (starting && v->causality == FMU_PARAMETER))) {
            fmu_say(fmu, FMU_ERROR,
                    "%s: %s cannot be a known; knowns are the inputs and, in "
                    "initializationMode, the parameters.",
                    function, v ? v->name : "a value reference that does not exist");
            return false;
        }
        *(double *)((input ? (char *)d_input : (char *)fmu->d_parameters) + v->offset) += seeds[i];
    }
    return true;
}

/* Of the outputs held now, by the inputs that the last step ran with. */
static void last_step_tangent(const struct fmu *fmu, const double d_input[FMU_INPUTS],
                              struct fmu_outputs *d_output)
{
    const struct fmu_model *model = fmu->model;
    const struct fmu_span step = fmu_last_step(fmu->now);
    const double sample_time = fmu_sample_time(fmu);
    double input[FMU_INPUTS];
    struct fmu_outputs output;

    memcpy(fmu->before, fmu->last_state, model->state_size);
    memset(fmu->d_state, 0, model->state_size);
    for (int64_t tick = step.first_tick; tick < step.end_tick; tick++) {
        const double time = (double)tick * sample_time;
        fmu_inputs_at(&step, tick, sample_time, input);
        model->tick_tangent(fmu->constants, fmu->before, input, time, fmu->d_state, d_input, d_output);
        model->tick(fmu->constants, fmu->before, fmu->parameters, input, time, &output);
    }
}

static bool unknowns_are_outputs(const struct fmu *fmu, const char *function, const unsigned unknowns[],
                                 size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, unknowns[i]);
        if (v && v->base == FMU_REAL && v->causality == FMU_OUTPUT)
            continue;
        fmu_say(fmu, FMU_ERROR, "%s: %s is not an unknown; unknowns are the Real outputs.", function,
                v ? v->name : "a value reference that does not exist");
        return false;
    }
    return true;
}

enum fmu_status fmu_directional_derivative(struct fmu *fmu, const char *function, const unsigned unknowns[],
                                           size_t unknown_count, const unsigned knowns[], size_t known_count,
                                           const double seeds[], double values[])
{
    double d_input[FMU_INPUTS] = { 0.0 };
    struct fmu_outputs d_output = { { 0.0 }, { 0 } };

    if (!fmu_may(fmu, function, FMU_INITIALIZATION | FMU_STEP_COMPLETE | FMU_TERMINATED))
        return FMU_ERROR;
    if (!fmu->model->tick_tangent)
        return fmu_lacks(fmu, function);
    if ((unknown_count && (!unknowns || !values)) || (known_count && (!knowns || !seeds)))
        return fmu_say(fmu, FMU_ERROR, "%s: an array is a null pointer.", function);
    const bool starting = fmu->now->phase == FMU_INITIALIZATION;
    memset(fmu->d_parameters, 0, fmu->model->parameters_size);
    if (!collect_seeds(fmu, function, knowns, known_count, seeds, starting, d_input) ||
        !unknowns_are_outputs(fmu, function, unknowns, unknown_count))
        return FMU_ERROR;
    const struct fmu_span last = fmu_last_step(fmu->now);
    if (!starting && (double)last.end_tick - (double)last.first_tick > LONGEST_DERIVATIVE)
        return fmu_say(fmu, FMU_DISCARD,
                       "%s: the last step has more than %d ticks; derivatives are "
                       "those of shorter ones.",
                       function, LONGEST_DERIVATIVE);
    if (!starting)
        last_step_tangent(fmu, d_input, &d_output);
    else if (fmu_start_outputs(fmu, function) != FMU_OK)
        return FMU_ERROR;
    else
        fmu->model->start_tangent(fmu->constants, fmu->state, fmu->parameters, fmu->d_parameters, &d_output);
    for (size_t i = 0; i < unknown_count; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, unknowns[i]);
        const double value = *(const double *)((const char *)&d_output + v->offset);
        if (!isfinite(value))
            return fmu_say(fmu, FMU_DISCARD,
                           "%s: the derivative of %s is no finite number for these "
                           "seeds.",
                           function, v->name);
        values[i] = value;
    }
    return FMU_OK;
}

/* --- fmu_adjoint.c --- */

/* Adjoint derivatives, from directional ones: of each known, the derivatives of the unknowns weighted by their
 * seeds. The models have few inputs, and a vector times a matrix costs no more than the matrix. */

enum fmu_status fmu_adjoint_derivative(struct fmu *fmu, const char *function, const unsigned unknowns[],
                                       size_t unknown_count, const unsigned knowns[], size_t known_count,
                                       const double seeds[], double values[])
{
    static const double one = 1.0;
    enum fmu_status status = FMU_OK;

    if (known_count == 0) /* the call is checked all the same */
        return fmu_directional_derivative(fmu, function, NULL, 0, NULL, 0, NULL, NULL);
    double *column = malloc((unknown_count + known_count) * sizeof *column);
    if (!column)
        return fmu ? fmu_say(fmu, FMU_ERROR, "%s: out of memory.", function) : FMU_ERROR;
    double *found = column + unknown_count; /* nothing is handed out where the last one is refused */
    for (size_t j = 0; j < known_count && status == FMU_OK; j++) {
        status =
            fmu_directional_derivative(fmu, function, unknowns, unknown_count, knowns + j, 1, &one, column);
        found[j] = 0.0;
        for (size_t i = 0; i < unknown_count && status == FMU_OK; i++)
            found[j] += seeds[i] * column[i];
    }
    for (size_t j = 0; j < known_count && status == FMU_OK; j++)
        values[j] = found[j];
    free(column);
    return status;
}

/* --- fmu_arrays.c --- */

/* Groups of parameters as arrays. The table has a row for every element there may be; how many are in use is a
 * parameter, which a host that knows arrays sets before all others. */

static bool has_structural_parameter(const struct fmu_model *model)
{
    for (unsigned i = 0; i < model->rows; i++) {
        const struct fmu_variable *v = fmu_find(model, i);
        if (v && v->base == FMU_INTEGER && v->causality == FMU_PARAMETER)
            return true;
    }
    return false;
}

enum fmu_status fmu_enter_configuration(struct fmu *fmu, const char *function)
{
    if (!fmu_may(fmu, function, FMU_INSTANTIATED))
        return FMU_ERROR;
    if (!has_structural_parameter(fmu->model))
        return fmu_say(fmu, FMU_ERROR, "%s: %s has no structural parameters.", function,
                       fmu->model->identifier);
    fmu->now->phase = FMU_CONFIGURATION;
    return FMU_OK;
}

enum fmu_status fmu_exit_configuration(struct fmu *fmu, const char *function)
{
    if (!fmu_may(fmu, function, FMU_CONFIGURATION))
        return FMU_ERROR;
    fmu->now->phase = FMU_INSTANTIATED;
    return FMU_OK;
}

/* How many values there are behind a reference: one of what is not there, too. */
static size_t length(const struct fmu *fmu, unsigned reference)
{
    const struct fmu_variable *v = fmu_find(fmu->model, reference);

    return v && v->index == 1 ? (size_t)*(const int *)((const char *)fmu->parameters + v->count) : 1;
}

/* Of what stands in an array, only the array has a reference that a host knows. */
static bool is_hidden(const struct fmu *fmu, unsigned reference)
{
    const struct fmu_variable *v = fmu_find(fmu->model, reference);

    return v && v->index > 1;
}

/* Do the references stand for so many values? */
static bool lengths_agree(const struct fmu *fmu, const char *function, const unsigned references[],
                          size_t count, size_t value_count)
{
    size_t total = 0;

    for (size_t i = 0; i < count; i++) {
        if (is_hidden(fmu, references[i])) {
            fmu_say(fmu, FMU_ERROR, "%s: %s has no variable with the value reference %u.", function,
                    fmu->model->identifier, references[i]);
            return false;
        }
        total += length(fmu, references[i]);
    }
    if (total == value_count)
        return true;
    fmu_say(fmu, FMU_ERROR, "%s: there are %zu values for variables that have %zu.", function, value_count,
            total);
    return false;
}

/* References of scalars: those given, or where arrays are among them the elements' in a block of their own. */
struct scalars {
    const unsigned *reference;
    size_t count;
    unsigned *block;
};

static bool expand(const struct fmu *fmu, const char *function, const unsigned references[], size_t count,
                   size_t value_count, struct scalars *scalars)
{
    *scalars = (struct scalars){ references, count, NULL };
    if (!lengths_agree(fmu, function, references, count, value_count))
        return false;
    if (value_count == 0)
        scalars->count = 0;
    bool arrays = false;
    for (size_t i = 0; i < count; i++)
        arrays |= length(fmu, references[i]) != 1;
    if (!arrays || value_count == 0)
        return true;
    unsigned *next = scalars->block = malloc(value_count * sizeof *next);
    if (!next) {
        fmu_say(fmu, FMU_ERROR, "%s: out of memory.", function);
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, references[i]);
        for (size_t k = 0; k < length(fmu, references[i]); k++)
            *next++ = references[i] + (v ? (unsigned)k * v->stride : 0);
    }
    scalars->reference = scalars->block;
    scalars->count = value_count;
    return true;
}

enum fmu_status fmu_get_arrays(struct fmu *fmu, const char *function, const unsigned references[], size_t count,
                               double values[], size_t value_count)
{
    if (!fmu_may(fmu, function, FMU_INITIALIZATION | FMU_INITIALIZED | (fmu ? fmu->host.reads : 0)) ||
        fmu_null_arrays(fmu, function, references, values, count) ||
        !lengths_agree(fmu, function, references, count, value_count))
        return FMU_ERROR;
    for (size_t i = 0; i < count; i++) {
        if (references[i] == fmu->model->rows) {
            *values++ = fmu->now->clock.time;
            continue;
        }
        const size_t elements = length(fmu, references[i]);
        for (size_t k = 0; k < elements; k++) {
            const unsigned element =
                references[i] + (k ? (unsigned)k * fmu->model->table[references[i]].stride : 0);
            if (fmu_get_real(fmu, function, &element, 1, values++) != FMU_OK)
                return FMU_ERROR;
        }
    }
    return FMU_OK;
}

enum fmu_status fmu_set_arrays(struct fmu *fmu, const char *function, const unsigned references[], size_t count,
                               const double values[], size_t value_count)
{
    struct scalars scalars;

    if (!fmu || fmu_null_arrays(fmu, function, references, values, count) ||
        !expand(fmu, function, references, count, value_count, &scalars))
        return FMU_ERROR;
    const enum fmu_status status = fmu_set_real(fmu, function, scalars.reference, scalars.count, values);
    free(scalars.block);
    return status;
}

enum fmu_status fmu_derivative_of_arrays(struct fmu *fmu, const char *function, fmu_derivative *derivative,
                                         const unsigned unknowns[], size_t unknown_count,
                                         const unsigned knowns[], size_t known_count, const double seeds[],
                                         size_t seed_count, double values[], size_t value_count)
{
    const bool adjoint = derivative == fmu_adjoint_derivative;
    struct scalars of, by = { 0 };
    enum fmu_status status = FMU_ERROR;

    if (!fmu || fmu_null_arrays(fmu, function, unknowns, adjoint ? seeds : values, unknown_count) ||
        fmu_null_arrays(fmu, function, knowns, adjoint ? values : seeds, known_count) ||
        !expand(fmu, function, unknowns, unknown_count, adjoint ? seed_count : value_count, &of))
        return FMU_ERROR;
    if (expand(fmu, function, knowns, known_count, adjoint ? value_count : seed_count, &by))
        status = derivative(fmu, function, of.reference, of.count, by.reference, by.count, seeds, values);
    free(of.block);
    free(by.block);
    return status;
}

/* --- fmu_state.c --- */

/* The FMU state is a plain value: copying it is saving it. Serialized, it is preceded by a header
 * that says which binary layout and model it belongs to and guards against damage. */

struct header {
    char magic[8];
    uint64_t order; /* tells byte orders apart */
    uint64_t table_hash;
    uint64_t size;
    uint64_t checksum;
};

static const char MAGIC[8] = "it2hys4";
static const uint64_t ORDER = 0x0102030405060708u;

uint64_t fmu_hash(const void *bytes, size_t size)
{
    const unsigned char *byte = bytes;
    uint64_t hash = 14695981039346656037u;

    for (size_t i = 0; i < size; i++)
        hash = (hash ^ byte[i]) * 1099511628211u;
    return hash;
}

/* The parts of a block that hold a snapshot and what is behind it. */
static const struct fmu_snapshot *snapshot_in(const void *block)
{
    return block;
}

static const void *parameters_in(const void *block)
{
    return snapshot_in(block) + 1;
}

static struct header header_of(const struct fmu_model *model, const void *block)
{
    const size_t size = fmu_snapshot_size(model);
    struct header header = {
        .order = ORDER, .table_hash = model->table_hash, .size = size, .checksum = fmu_hash(block, size)
    };

    memcpy(header.magic, MAGIC, sizeof MAGIC);
    return header;
}

static size_t serialized_size(const struct fmu *fmu)
{
    return sizeof(struct header) + fmu_snapshot_size(fmu->model);
}

enum fmu_status fmu_get_state(struct fmu *fmu, const char *function, void **state)
{
    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (!state)
        return fmu_say(fmu, FMU_ERROR, "%s: FMUstate is a null pointer.", function);
    const size_t size = fmu_snapshot_size(fmu->model);
    if (!*state)
        *state = malloc(size);
    if (!*state)
        return fmu_say(fmu, FMU_ERROR, "%s: out of memory.", function);
    fmu_gather(fmu);
    memcpy(*state, fmu->now, size);
    return FMU_OK;
}

static void adopt(struct fmu *fmu, const void *block)
{
    const struct fmu_model *model = fmu->model;
    /* a master that goes back to try again does so with the same parameters: they are prepared */
    const bool prepared =
        !fmu->outputs_stale && memcmp(fmu->parameters, parameters_in(block), model->parameters_size) == 0;

    fmu_gather(fmu);
    memcpy(fmu->now, block, fmu_snapshot_size(model));
    memcpy(fmu->before, fmu->last_state, model->state_size);
    fmu_note_ramps(fmu);
    /* before initialization is over the parameters are not checked yet: outputs are computed on demand */
    fmu->outputs_stale = !(fmu->now->phase & FMU_INITIALIZED);
    if (fmu->outputs_stale)
        return;
    if (!prepared)
        fmu->used = model->prepare(fmu->constants, fmu->parameters);
    fmu_settle(fmu); /* what was prepared last may have been in initialization */
}

enum fmu_status fmu_set_state(struct fmu *fmu, const char *function, const void *state)
{
    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (!state)
        return fmu_say(fmu, FMU_ERROR, "%s: FMUstate is a null pointer.", function);
    adopt(fmu, state);
    return FMU_OK;
}

enum fmu_status fmu_free_state(struct fmu *fmu, const char *function, void **state)
{
    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return FMU_OK;
}

enum fmu_status fmu_state_size(struct fmu *fmu, const char *function, const void *state, size_t *size)
{
    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (!state || !size)
        return fmu_say(fmu, FMU_ERROR, "%s: a null pointer.", function);
    *size = serialized_size(fmu);
    return FMU_OK;
}

enum fmu_status fmu_serialize(struct fmu *fmu, const char *function, const void *state, char bytes[],
                              size_t size)
{
    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (!state || !bytes)
        return fmu_say(fmu, FMU_ERROR, "%s: a null pointer.", function);
    if (size < serialized_size(fmu))
        return fmu_say(fmu, FMU_ERROR, "%s: %zu bytes are too few; %zu are needed.", function, size,
                       serialized_size(fmu));
    const struct header header = header_of(fmu->model, state);
    memcpy(bytes, &header, sizeof header);
    memcpy(bytes + sizeof header, state, fmu_snapshot_size(fmu->model));
    return FMU_OK;
}

static bool doubles_finite(const void *first, size_t size)
{
    const double *value = first;

    for (size_t i = 0; i < size / sizeof *value; i++)
        if (!isfinite(value[i]))
            return false;
    return true;
}

/* A step or a derivative from invented ticks would not return. */
static bool ticks_plausible(const struct fmu_snapshot *s, double sample_time)
{
    if (!fmu_clock_plausible(&s->clock, sample_time) || s->one_tick > 1)
        return false;
    const struct fmu_span last = fmu_last_step(s);
    const double ticks = (double)last.end_tick - (double)last.first_tick;
    return ticks >= 0.0 && ticks <= 2.0 * CLOCK_LONGEST_STEP && fabs((double)last.tick) <= CLOCK_LARGEST_TICK &&
           last.rest >= 0.0 && last.rest < 1.0 && (ticks == 0.0 || last.end_tick == s->clock.next_tick);
}

/* What is neither a parameter, an output, nor the clock's. */
static bool all_finite(const struct fmu_model *model, const void *block)
{
    const struct fmu_snapshot *s = block;
    const struct fmu_span *last = &s->last_step;

    return doubles_finite(s->input, sizeof s->input) && doubles_finite(s->slope, sizeof s->slope) &&
           isfinite(last->rest) && doubles_finite(last->input, sizeof last->input) &&
           doubles_finite(last->slope, sizeof last->slope) &&
           doubles_finite(fmu_state_in(model, block), 2 * model->state_size);
}

/* A checksum stops damage, not invention: what a step relies on and what is handed out is checked too.
 * Returns what cannot be, or NULL; `message` is room for it. */
static const char *invented(const struct fmu *fmu, const void *block, char *message, size_t size)
{
    const struct fmu_snapshot *s = block;
    const void *parameters = parameters_in(block);
    const bool one_phase = s->phase == FMU_INSTANTIATED || s->phase == FMU_INITIALIZATION ||
                           s->phase == FMU_STEP_COMPLETE || s->phase == FMU_TERMINATED ||
                           (s->phase == FMU_CONFIGURATION && fmu->host.resizes);

    if (!one_phase || s->last_status < 0 || s->last_status > FMU_DISCARD || s->warned >= FMU_NOT_FINITE)
        return "no such phase, status or finding";
    if (!all_finite(fmu->model, block))
        return "a number is not finite";
    if (!fmu_values_possible(fmu, s, parameters, message, size))
        return message;
    if (!(s->phase & FMU_INITIALIZED))
        return isfinite(s->clock.time) && s->clock.stop_time > -INFINITY ? NULL : "no such time";
    if (!fmu->model->check(fmu->model, parameters, message, size))
        return message;
    return ticks_plausible(s, *(const double *)parameters) ? NULL : "the ticks are not those of the time";
}

enum fmu_status fmu_deserialize(struct fmu *fmu, const char *function, const char bytes[], size_t size,
                                void **state)
{
    char message[512];

    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (!bytes || !state)
        return fmu_say(fmu, FMU_ERROR, "%s: a null pointer.", function);
    const struct fmu_model *model = fmu->model;
    if (size != serialized_size(fmu))
        return fmu_say(fmu, FMU_ERROR, "%s: %zu bytes are no state of %s, which has %zu.", function, size,
                       model->identifier, serialized_size(fmu));
    void *block = malloc(fmu_snapshot_size(model));
    if (!block)
        return fmu_say(fmu, FMU_ERROR, "%s: out of memory.", function);
    memcpy(block, bytes + sizeof(struct header), fmu_snapshot_size(model));
    const struct header header = header_of(model, block);
    const char *reason = memcmp(&header, bytes, sizeof header) != 0
                             ? "header or checksum is wrong"
                             : invented(fmu, block, message, sizeof message);
    if (reason) {
        free(block);
        return fmu_say(fmu, FMU_ERROR,
                       "%s: these bytes are damaged or not a state of this version of "
                       "%s: %s.",
                       function, model->identifier, reason);
    }
    *state = block; /* never read before: masters pass it uninitialised */
    return FMU_OK;
}

/* --- fmu_log.c --- */

/* In the order of enum fmu_status, and all of them. */
static const struct {
    const char *name;
    unsigned category;
} CATEGORIES[] = {
    [FMU_OK] = { "logEvents", FMU_LOG_EVENTS },
    [FMU_WARNING] = { "logStatusWarning", FMU_LOG_WARNING },
    [FMU_DISCARD] = { "logStatusDiscard", FMU_LOG_DISCARD },
    [FMU_ERROR] = { "logStatusError", FMU_LOG_ERROR },
    { "logAll", FMU_LOG_ALL },
};
enum { CATEGORY_COUNT = sizeof CATEGORIES / sizeof CATEGORIES[0] };

static const char *phase_name(int phase)
{
    switch (phase) {
    case FMU_INSTANTIATED: return "instantiated";
    case FMU_INITIALIZATION: return "initializationMode";
    case FMU_STEP_COMPLETE: return "stepComplete";
    case FMU_CONFIGURATION: return "configurationMode";
    case FMU_UPDATE: return "intermediateUpdateMode";
    default: return "terminated";
    }
}

static enum fmu_status hand_over(const struct fmu_host *host, const char *name, enum fmu_status status,
                                 const char *text)
{
    host->log(host, name, status, CATEGORIES[status].name, text);
    return status;
}

enum fmu_status fmu_say(const struct fmu *fmu, enum fmu_status status, const char *format, ...)
{
    char text[1024];
    va_list arguments;

    if (!fmu->host.log || !(fmu->categories & CATEGORIES[status].category))
        return status;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return hand_over(&fmu->host, fmu->name, status, text);
}

enum fmu_status fmu_say_early(const struct fmu_host *host, const char *name, const char *text)
{
    return host->log ? hand_over(host, name, FMU_ERROR, text) : FMU_ERROR;
}

bool fmu_refuse(const struct fmu *fmu, const char *function)
{
    if (fmu)
        fmu_say(fmu, FMU_ERROR, "%s: not allowed in the state %s; this instance is left as it is.", function,
                phase_name(fmu->now->phase));
    return false;
}

enum fmu_status fmu_lacks(const struct fmu *fmu, const char *function)
{
    return fmu_say(fmu, FMU_ERROR, "%s: not supported, as the model description says.", function);
}

enum fmu_status fmu_set_debug_logging(struct fmu *fmu, const char *function, bool on, size_t count,
                                      const char *const categories[])
{
    unsigned chosen = count == 0 ? FMU_LOG_ALL : 0;

    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (count > 0 && !categories)
        return fmu_say(fmu, FMU_ERROR, "%s: categories is a null pointer.", function);
    for (size_t i = 0; i < count; i++) {
        int k = 0;
        while (k < CATEGORY_COUNT && categories[i] && strcmp(categories[i], CATEGORIES[k].name) != 0)
            k++;
        if (k == CATEGORY_COUNT || !categories[i])
            return fmu_say(fmu, FMU_ERROR,
                           "%s: unknown log category '%s'; known are logEvents, logStatusWarning, "
                           "logStatusDiscard, logStatusError and logAll.",
                           function, categories[i] ? categories[i] : "(null)");
        chosen |= CATEGORIES[k].category;
    }
    if (on)
        fmu->categories |= chosen;
    else
        fmu->categories &= ~chosen;
    return FMU_OK;
}

#if !defined IT2HYS_NO_RESOURCES

/* --- fmu_parameters.c --- */

/* The parameter set of a packaged FMU.
 *
 * A GUID is {table hash, parameter hash}, 64 bits each: it says which variables the XML lists and
 * which parameter set its start values are. One binary serves every packaged FMU: where the set
 * compiled in is not the one meant, it is read from resources/parameters.ssv. XML, resources and
 * binary therefore agree, or there is no instance. */

enum { LARGEST_FILE = 1 << 20, LARGEST_NUMBER = 64 };

static const char ENTRY[] = "<ssv:Parameter name=\"";
static const char ENTRY_END[] = "</ssv:Parameter>";
static const char VALUE[] = " value=\"";

/* strtod reads the decimal point of the host's locale, the file has a point. */
static bool read_number(const char *text, size_t length, double *value)
{
    const char *point = localeconv()->decimal_point;
    char buffer[LARGEST_NUMBER];
    size_t n = 0;
    char *end;

    for (size_t i = 0; i < length; i++) {
        const char *piece = text[i] == '.' ? point : text + i;
        const size_t size = text[i] == '.' ? strlen(point) : 1;
        if (n + size >= sizeof buffer)
            return false;
        memcpy(buffer + n, piece, size);
        n += size;
    }
    buffer[n] = '\0';
    *value = strtod(buffer, &end);
    return n > 0 && end == buffer + n && isfinite(*value);
}

static bool set_parameter(const struct fmu_model *model, void *parameters, const char *name, size_t name_length,
                          const char *text, size_t length)
{
    const struct fmu_variable *variable = fmu_find_parameter(model, name, name_length);
    double value;

    if (!variable)
        return false;
    if (variable->base == FMU_BOOLEAN && length >= 4)
        value = strncmp(text, "true", 4) == 0;
    else if (!read_number(text, length, &value))
        return false;
    /* beyond its bounds, a number may have no int to be converted to */
    if (variable->base == FMU_INTEGER && !(value >= variable->minimum && value <= variable->maximum))
        return false;
    void *target = (char *)parameters + variable->offset;
    if (variable->base == FMU_REAL)
        *(double *)target = value;
    else
        *(int *)target = (int)value;
    return true;
}

/* Reads the SSV text that the packager writes; the hash has shown that it is that text. */
static bool parse(const struct fmu_model *model, const char *text, void *parameters, char *message, size_t size)
{
    memset(parameters, 0, model->parameters_size);
    for (const char *entry = strstr(text, ENTRY); entry; entry = strstr(entry, ENTRY)) {
        const char *name = entry + sizeof ENTRY - 1;
        const size_t name_length = strcspn(name, "\"");
        const char *end = strstr(name, ENTRY_END);
        const char *value = strstr(name, VALUE);
        if (end && value && value < end) {
            value += sizeof VALUE - 1;
            if (!set_parameter(model, parameters, name, name_length, value, strcspn(value, "\""))) {
                snprintf(message, size,
                         "parameters.ssv: parameter '%.*s' is unknown, or its value is "
                         "not valid",
                         (int)(name_length < 80 ? name_length : 80), name);
                return false;
            }
        }
        entry = name;
    }
    return true;
}

static char *read_all(FILE *file)
{
    char *text = malloc(LARGEST_FILE + 1);
    const size_t size = text ? fread(text, 1, LARGEST_FILE, file) : 0;

    if (text)
        text[size] = '\0';
    return text;
}

bool fmu_load_parameters(const struct fmu_model *model, uint64_t hash, const char *resources, void *parameters,
                         char *message, size_t size)
{
    char path[2048] = "";
    FILE *file = fmu_open_resource(resources, "parameters.ssv", path, sizeof path);
    char *text = file ? read_all(file) : NULL;
    bool ok = false;

    if (file)
        fclose(file);
    if (!text)
        snprintf(message, size, "the parameter set cannot be read from '%s' (resource location '%s').", path,
                 resources ? resources : "(null)");
    else if (fmu_hash(text, strlen(text)) != hash)
        snprintf(message, size,
                 "'%s' is not the parameter set that modelDescription.xml was made for; "
                 "package the FMU anew instead of editing it.",
                 path);
    else
        ok = parse(model, text, parameters, message, size);
    free(text);
    return ok;
}

#endif

#if !defined IT2HYS_NO_RESOURCES

/* --- fmu_location.c --- */

/* Where the FMU's resources are: at the URI that the host gives, or beside this very binary, which
 * lies in binaries/<platform>/ of the unpacked FMU. Hosts differ in the URI: with and without a
 * trailing slash, file:/ or file:///, percent-encoded or not, a plain path, or none at all. */

#if defined _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif

static const char ANCHOR = 0; /* an address within this binary */

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

static void decode_percent(char *text)
{
    char *out = text;

    for (; *text; text++, out++) {
        if (*text == '%' && hex_digit(text[1]) >= 0 && hex_digit(text[2]) >= 0) {
            *out = (char)(16 * hex_digit(text[1]) + hex_digit(text[2]));
            text += 2;
        } else
            *out = *text;
    }
    *out = '\0';
}

/* Path of a file: URI; a text that is no URI is taken as a path. */
static bool uri_to_path(const char *uri, char *path, size_t size)
{
    const bool is_uri = strncmp(uri, "file:", 5) == 0;
    const char *rest = is_uri ? uri + 5 : uri;

    if (is_uri && strncmp(rest, "//", 2) == 0) {
        rest += 2; /* an authority may follow: nothing or localhost */
        if (strncmp(rest, "localhost/", 10) == 0)
            rest += 9;
    }
#if defined _WIN32
    if (is_uri && rest[0] == '/' && rest[1] && rest[2] == ':')
        rest++; /* /C:/... */
#endif
    if (strlen(rest) >= size)
        return false;
    strcpy(path, rest);
    if (is_uri)
        decode_percent(path);
    return true;
}

static bool append(char *path, size_t size, const char *text)
{
    if (strlen(path) + strlen(text) >= size)
        return false;
    strcat(path, text);
    return true;
}

#if defined _WIN32
static FILE *open_utf8(const char *path)
{
    WCHAR wide[2048];

    return MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 2048) ? _wfopen(wide, L"rb") : NULL;
}

static bool own_path(char *path, size_t size)
{
    WCHAR wide[2048];
    HMODULE module;
    const DWORD flags = GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT;

    if (!GetModuleHandleExW(flags, (LPCWSTR)(const void *)&ANCHOR, &module))
        return false;
    const DWORD length = GetModuleFileNameW(module, wide, 2048);
    return length > 0 && length < 2048 &&
           WideCharToMultiByte(CP_UTF8, 0, wide, -1, path, (int)size, NULL, NULL) > 0;
}
#else
static FILE *open_utf8(const char *path)
{
    return fopen(path, "rb");
}

static bool own_path(char *path, size_t size)
{
    Dl_info info;

    if (!dladdr(&ANCHOR, &info) || !info.dli_fname || strlen(info.dli_fname) >= size)
        return false;
    strcpy(path, info.dli_fname);
    return true;
}
#endif

/* <fmu>/binaries/<platform>/<binary> -> <fmu>/resources */
static bool own_resources(char *path, size_t size)
{
    if (!own_path(path, size))
        return false;
    for (int level = 0; level < 3; level++) {
        char *slash = strrchr(path, '/');
        char *backslash = strrchr(path, '\\');
        char *last = backslash > slash ? backslash : slash;
        if (!last)
            return false;
        *last = '\0';
    }
    return append(path, size, "/resources");
}

void *fmu_open_resource(const char *uri, const char *file, char *path, size_t size)
{
    FILE *opened = NULL;

    if (uri && *uri && uri_to_path(uri, path, size) && append(path, size, "/") && append(path, size, file))
        opened = open_utf8(path);
    if (!opened && own_resources(path, size) && append(path, size, "/") && append(path, size, file))
        opened = open_utf8(path);
    return opened;
}

#endif

/* --- actuator.c --- */

/* --- fmu_table.h --- */

/* Generated from variables.toml by codegen.py. */
const struct fmu_variable actuator_table[] = {
    { "voltage", FMU_REAL, FMU_INPUT, FMU_PLANT, 0 * sizeof(double), -2000.0, 2000.0, 0, 0, 0 },
    { "reference", FMU_REAL, FMU_INPUT, FMU_INVERSE, 0 * sizeof(double), -0.1, 0.1, 0, 0, 0 },
    { "force", FMU_REAL, FMU_INPUT, FMU_PLANT | FMU_INVERSE, 1 * sizeof(double), -1000000.0, 1000000.0, 0, 0, 0 },
    { "temperature", FMU_REAL, FMU_INPUT, FMU_PLANT | FMU_INVERSE, 2 * sizeof(double), 0, 1000.0, 0, 0, 0 },
    { "displacement", FMU_REAL, FMU_OUTPUT, FMU_PLANT, offsetof(struct fmu_outputs, real[0]), -0.1, 0.1, 0, 0, 0 },
    { "measured", FMU_REAL, FMU_OUTPUT, FMU_PLANT, offsetof(struct fmu_outputs, real[1]), -0.1, 0.1, 0, 0, 0 },
    { "voltage", FMU_REAL, FMU_OUTPUT, FMU_INVERSE, offsetof(struct fmu_outputs, real[0]), -2000.0, 2000.0, 0, 0, 0 },
    { "saturated", FMU_BOOLEAN, FMU_OUTPUT, FMU_INVERSE, offsetof(struct fmu_outputs, flag[0]), 0, 0, 0, 0, 0 },
    { "sampleTime", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, sampleTime), 1e-09, 1000.0, 0, 0, 0 },
    { "initialDisplacement", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, initialDisplacement), -0.1, 0.1, 0, 0, 0 },
    { "voltageMin", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, voltageMin), -2000.0, 2000.0, 0, 0, 0 },
    { "voltageMax", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, voltageMax), -2000.0, 2000.0, 0, 0, 0 },
    { "displacementMin", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, displacementMin), -0.1, 0.1, 0, 0, 0 },
    { "displacementMax", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, displacementMax), -0.1, 0.1, 0, 0, 0 },
    { "ruleCount", FMU_INTEGER, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, ruleCount), 1, 16, 0, 0, 0 },
    { "rule[1].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[0].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 1, 6 },
    { "rule[1].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[0].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 1, 6 },
    { "rule[1].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[0].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 1, 6 },
    { "rule[1].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[0].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 1, 6 },
    { "rule[1].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[0].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 1, 6 },
    { "rule[1].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[0].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 1, 6 },
    { "rule[2].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[1].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 2, 6 },
    { "rule[2].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[1].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 2, 6 },
    { "rule[2].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[1].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 2, 6 },
    { "rule[2].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[1].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 2, 6 },
    { "rule[2].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[1].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 2, 6 },
    { "rule[2].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[1].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 2, 6 },
    { "rule[3].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[2].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 3, 6 },
    { "rule[3].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[2].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 3, 6 },
    { "rule[3].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[2].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 3, 6 },
    { "rule[3].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[2].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 3, 6 },
    { "rule[3].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[2].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 3, 6 },
    { "rule[3].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[2].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 3, 6 },
    { "rule[4].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[3].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 4, 6 },
    { "rule[4].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[3].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 4, 6 },
    { "rule[4].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[3].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 4, 6 },
    { "rule[4].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[3].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 4, 6 },
    { "rule[4].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[3].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 4, 6 },
    { "rule[4].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[3].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 4, 6 },
    { "rule[5].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[4].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 5, 6 },
    { "rule[5].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[4].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 5, 6 },
    { "rule[5].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[4].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 5, 6 },
    { "rule[5].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[4].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 5, 6 },
    { "rule[5].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[4].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 5, 6 },
    { "rule[5].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[4].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 5, 6 },
    { "rule[6].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[5].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 6, 6 },
    { "rule[6].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[5].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 6, 6 },
    { "rule[6].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[5].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 6, 6 },
    { "rule[6].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[5].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 6, 6 },
    { "rule[6].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[5].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 6, 6 },
    { "rule[6].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[5].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 6, 6 },
    { "rule[7].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[6].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 7, 6 },
    { "rule[7].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[6].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 7, 6 },
    { "rule[7].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[6].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 7, 6 },
    { "rule[7].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[6].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 7, 6 },
    { "rule[7].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[6].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 7, 6 },
    { "rule[7].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[6].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 7, 6 },
    { "rule[8].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[7].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 8, 6 },
    { "rule[8].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[7].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 8, 6 },
    { "rule[8].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[7].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 8, 6 },
    { "rule[8].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[7].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 8, 6 },
    { "rule[8].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[7].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 8, 6 },
    { "rule[8].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[7].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 8, 6 },
    { "rule[9].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[8].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 9, 6 },
    { "rule[9].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[8].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 9, 6 },
    { "rule[9].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[8].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 9, 6 },
    { "rule[9].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[8].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 9, 6 },
    { "rule[9].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[8].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 9, 6 },
    { "rule[9].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[8].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 9, 6 },
    { "rule[10].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[9].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 10, 6 },
    { "rule[10].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[9].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 10, 6 },
    { "rule[10].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[9].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 10, 6 },
    { "rule[10].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[9].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 10, 6 },
    { "rule[10].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[9].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 10, 6 },
    { "rule[10].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[9].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 10, 6 },
    { "rule[11].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[10].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 11, 6 },
    { "rule[11].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[10].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 11, 6 },
    { "rule[11].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[10].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 11, 6 },
    { "rule[11].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[10].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 11, 6 },
    { "rule[11].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[10].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 11, 6 },
    { "rule[11].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[10].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 11, 6 },
    { "rule[12].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[11].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 12, 6 },
    { "rule[12].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[11].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 12, 6 },
    { "rule[12].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[11].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 12, 6 },
    { "rule[12].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[11].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 12, 6 },
    { "rule[12].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[11].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 12, 6 },
    { "rule[12].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[11].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 12, 6 },
    { "rule[13].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[12].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 13, 6 },
    { "rule[13].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[12].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 13, 6 },
    { "rule[13].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[12].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 13, 6 },
    { "rule[13].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[12].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 13, 6 },
    { "rule[13].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[12].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 13, 6 },
    { "rule[13].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[12].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 13, 6 },
    { "rule[14].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[13].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 14, 6 },
    { "rule[14].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[13].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 14, 6 },
    { "rule[14].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[13].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 14, 6 },
    { "rule[14].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[13].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 14, 6 },
    { "rule[14].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[13].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 14, 6 },
    { "rule[14].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[13].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 14, 6 },
    { "rule[15].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[14].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 15, 6 },
    { "rule[15].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[14].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 15, 6 },
    { "rule[15].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[14].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 15, 6 },
    { "rule[15].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[14].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 15, 6 },
    { "rule[15].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[14].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 15, 6 },
    { "rule[15].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[14].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 15, 6 },
    { "rule[16].sigmaLower", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[15].sigmaLower), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 16, 6 },
    { "rule[16].sigmaUpper", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[15].sigmaUpper), 1e-12, 1.0, offsetof(struct chain_parameters, ruleCount), 16, 6 },
    { "rule[16].centre", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[15].centre), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 16, 6 },
    { "rule[16].q1", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[15].q1), -10.0, 10.0, offsetof(struct chain_parameters, ruleCount), 16, 6 },
    { "rule[16].q2", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[15].q2), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 16, 6 },
    { "rule[16].q3", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, rule[15].q3), -0.1, 0.1, offsetof(struct chain_parameters, ruleCount), 16, 6 },
    { "playCount", FMU_INTEGER, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, playCount), 0, 32, 0, 0, 0 },
    { "play[1].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[0].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 1, 2 },
    { "play[1].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[0].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 1, 2 },
    { "play[2].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[1].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 2, 2 },
    { "play[2].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[1].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 2, 2 },
    { "play[3].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[2].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 3, 2 },
    { "play[3].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[2].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 3, 2 },
    { "play[4].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[3].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 4, 2 },
    { "play[4].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[3].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 4, 2 },
    { "play[5].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[4].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 5, 2 },
    { "play[5].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[4].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 5, 2 },
    { "play[6].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[5].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 6, 2 },
    { "play[6].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[5].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 6, 2 },
    { "play[7].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[6].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 7, 2 },
    { "play[7].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[6].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 7, 2 },
    { "play[8].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[7].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 8, 2 },
    { "play[8].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[7].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 8, 2 },
    { "play[9].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[8].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 9, 2 },
    { "play[9].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[8].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 9, 2 },
    { "play[10].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[9].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 10, 2 },
    { "play[10].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[9].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 10, 2 },
    { "play[11].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[10].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 11, 2 },
    { "play[11].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[10].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 11, 2 },
    { "play[12].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[11].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 12, 2 },
    { "play[12].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[11].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 12, 2 },
    { "play[13].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[12].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 13, 2 },
    { "play[13].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[12].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 13, 2 },
    { "play[14].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[13].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 14, 2 },
    { "play[14].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[13].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 14, 2 },
    { "play[15].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[14].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 15, 2 },
    { "play[15].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[14].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 15, 2 },
    { "play[16].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[15].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 16, 2 },
    { "play[16].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[15].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 16, 2 },
    { "play[17].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[16].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 17, 2 },
    { "play[17].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[16].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 17, 2 },
    { "play[18].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[17].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 18, 2 },
    { "play[18].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[17].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 18, 2 },
    { "play[19].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[18].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 19, 2 },
    { "play[19].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[18].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 19, 2 },
    { "play[20].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[19].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 20, 2 },
    { "play[20].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[19].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 20, 2 },
    { "play[21].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[20].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 21, 2 },
    { "play[21].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[20].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 21, 2 },
    { "play[22].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[21].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 22, 2 },
    { "play[22].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[21].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 22, 2 },
    { "play[23].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[22].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 23, 2 },
    { "play[23].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[22].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 23, 2 },
    { "play[24].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[23].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 24, 2 },
    { "play[24].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[23].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 24, 2 },
    { "play[25].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[24].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 25, 2 },
    { "play[25].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[24].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 25, 2 },
    { "play[26].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[25].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 26, 2 },
    { "play[26].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[25].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 26, 2 },
    { "play[27].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[26].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 27, 2 },
    { "play[27].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[26].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 27, 2 },
    { "play[28].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[27].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 28, 2 },
    { "play[28].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[27].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 28, 2 },
    { "play[29].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[28].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 29, 2 },
    { "play[29].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[28].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 29, 2 },
    { "play[30].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[29].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 30, 2 },
    { "play[30].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[29].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 30, 2 },
    { "play[31].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[30].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 31, 2 },
    { "play[31].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[30].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 31, 2 },
    { "play[32].threshold", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[31].threshold), 0, 4000.0, offsetof(struct chain_parameters, playCount), 32, 2 },
    { "play[32].weight", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, play[31].weight), -10.0, 10.0, offsetof(struct chain_parameters, playCount), 32, 2 },
    { "creepCount", FMU_INTEGER, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creepCount), 0, 16, 0, 0, 0 },
    { "creep[1].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[0].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 1, 2 },
    { "creep[1].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[0].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 1, 2 },
    { "creep[2].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[1].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 2, 2 },
    { "creep[2].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[1].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 2, 2 },
    { "creep[3].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[2].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 3, 2 },
    { "creep[3].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[2].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 3, 2 },
    { "creep[4].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[3].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 4, 2 },
    { "creep[4].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[3].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 4, 2 },
    { "creep[5].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[4].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 5, 2 },
    { "creep[5].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[4].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 5, 2 },
    { "creep[6].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[5].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 6, 2 },
    { "creep[6].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[5].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 6, 2 },
    { "creep[7].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[6].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 7, 2 },
    { "creep[7].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[6].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 7, 2 },
    { "creep[8].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[7].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 8, 2 },
    { "creep[8].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[7].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 8, 2 },
    { "creep[9].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[8].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 9, 2 },
    { "creep[9].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[8].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 9, 2 },
    { "creep[10].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[9].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 10, 2 },
    { "creep[10].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[9].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 10, 2 },
    { "creep[11].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[10].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 11, 2 },
    { "creep[11].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[10].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 11, 2 },
    { "creep[12].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[11].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 12, 2 },
    { "creep[12].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[11].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 12, 2 },
    { "creep[13].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[12].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 13, 2 },
    { "creep[13].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[12].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 13, 2 },
    { "creep[14].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[13].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 14, 2 },
    { "creep[14].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[13].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 14, 2 },
    { "creep[15].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[14].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 15, 2 },
    { "creep[15].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[14].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 15, 2 },
    { "creep[16].gain", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[15].gain), -10.0, 10.0, offsetof(struct chain_parameters, creepCount), 16, 2 },
    { "creep[16].timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, creep[15].timeConstant), 0, 1000000.0, offsetof(struct chain_parameters, creepCount), 16, 2 },
    { "delay.time", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, delay.time), 0, 1000000.0, 0, 0, 0 },
    { "slew.rate", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, slew.rate), 0, 1000000000000.0, 0, 0, 0 },
    { "saturation.minimum", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, saturation.minimum), -2000.0, 2000.0, 0, 0, 0 },
    { "saturation.maximum", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, saturation.maximum), -2000.0, 2000.0, 0, 0, 0 },
    { "lag.timeConstant", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, lag.timeConstant), 0, 1000000.0, 0, 0, 0 },
    { "load.compliance", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, load.compliance), 0, 1.0, 0, 0, 0 },
    { "resonance.frequency", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, resonance.frequency), 0, 1000000000.0, 0, 0, 0 },
    { "resonance.damping", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, resonance.damping), 0, 1.0, 0, 0, 0 },
    { "resonance.samplingZero", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, resonance.samplingZero), -0.95, 0, 0, 0, 0 },
    { "resonance.samplingDelay", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, resonance.samplingDelay), 0, 1000000.0, 0, 0, 0 },
    { "drift.temperatureCoefficient", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, drift.temperatureCoefficient), -0.001, 0.001, 0, 0, 0 },
    { "drift.rate", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, drift.rate), -0.001, 0.001, 0, 0, 0 },
    { "nonlinearity.quadratic", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, nonlinearity.quadratic), -0.1, 0.1, 0, 0, 0 },
    { "nonlinearity.cubic", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, nonlinearity.cubic), -0.1, 0.1, 0, 0, 0 },
    { "nonlinearity.quartic", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, nonlinearity.quartic), -0.1, 0.1, 0, 0, 0 },
    { "hum.amplitude", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, hum.amplitude), -0.1, 0.1, 0, 0, 0 },
    { "hum.frequency", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, hum.frequency), 0, 1000000000.0, 0, 0, 0 },
    { "hum.phase", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, hum.phase), -100.0, 100.0, 0, 0, 0 },
    { "initialDemagnetisation", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, initialDemagnetisation), -2000.0, 2000.0, 0, 0, 0 },
    { "initialExcursion", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, initialExcursion), -2000.0, 2000.0, 0, 0, 0 },
    { "initialCreep", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, initialCreep), -0.1, 0.1, 0, 0, 0 },
    { "nonlinearity.minimum", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, nonlinearity.minimum), -0.1, 0.1, 0, 0, 0 },
    { "nonlinearity.maximum", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, nonlinearity.maximum), -0.1, 0.1, 0, 0, 0 },
    { "outOfRange", FMU_BOOLEAN, FMU_OUTPUT, FMU_PLANT, offsetof(struct fmu_outputs, flag[0]), 0, 0, 0, 0, 0 },
    { "displacementZero", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, displacementZero), -0.1, 0.1, 0, 0, 0 },
    { "nonlinearity.quintic", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, nonlinearity.quintic), -0.1, 0.1, 0, 0, 0 },
    { "nonlinearity.sextic", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, nonlinearity.sextic), -0.1, 0.1, 0, 0, 0 },
    { "initialCreepAge", FMU_REAL, FMU_PARAMETER, FMU_PLANT | FMU_INVERSE, offsetof(struct chain_parameters, initialCreepAge), 0, 1000000.0, 0, 0, 0 },
};

bool actuator_check(const struct fmu_model *model, const void *parameters, char *message, size_t size)
{
    return fmu_within_bounds(model, parameters, message, size) && chain_check(parameters, message, size);
}

bool actuator_settle(void *constants)
{
    struct actuator *actuator = constants;

    return it2_tabulate(&actuator->chain.core, &actuator->table) && actuator->chain.all == 0;
}

/* --- plant.c --- */

/* The plant: the chain walked forwards, from voltage to displacement. */

/* --- fmu_table_hash.h --- */

/* Generated from variables.toml by codegen.py. */
#define FMU_TABLE_HASH_PLANT 0xf07c7d43e208f3b0u
#define FMU_TABLE_HASH_INVERSE 0x00b7035e821c87d4u

enum plant_finding { PLANT_VOLTAGE_RANGE = 1, PLANT_DISPLACEMENT_RANGE = 2 };

static size_t plant_prepare(void *constants, const void *parameters)
{
    struct chain *chain = constants;

    chain_prepare(chain, parameters);
    chain_pass_by_idle(chain, parameters); /* arrays are not empty, for hosts that know arrays */
    return chain->walked;
}

/* Before the first tick the reading is taken as the displacement: hum begins with the ticks. */
static bool plant_start(const void *constants, void *state, const void *parameters, struct fmu_outputs *output,
                        char *message, size_t size)
{
    const struct chain_parameters *p = parameters;

    (void)message, (void)size;
    chain_reset(constants, state, parameters);
    output->real[OUT_DISPLACEMENT] = output->real[OUT_MEASURED] = p->initialDisplacement;
    output->flag[OUT_OUT_OF_RANGE] = 0;
    return true;
}

static void plant_start_tangent(const void *constants, const void *state, const void *parameters,
                                const void *d_parameters, struct fmu_outputs *d_output)
{
    const struct chain_parameters *d = d_parameters;

    (void)constants, (void)state, (void)parameters;
    d_output->real[OUT_DISPLACEMENT] = d_output->real[OUT_MEASURED] = d->initialDisplacement;
}

static unsigned plant_tick(const void *constants, void *state, const void *parameters,
                           const double input[FMU_INPUTS], double time, struct fmu_outputs *output)
{
    const struct chain_parameters *p = parameters;
    const struct chain_state *s = state;
    const double voltage = input[IN_VOLTAGE];
    const struct chain_surroundings around = actuator_surroundings(input, time);
    const double displacement = chain_step(constants, state, voltage, &around);
    const double measured = chain_measure(constants, displacement, time);
    unsigned findings = 0;

    if (!isfinite(measured))
        return FMU_NOT_FINITE;
    output->real[OUT_DISPLACEMENT] = displacement;
    output->real[OUT_MEASURED] = measured;
    if (chain_outside(voltage, p->voltageMin, p->voltageMax))
        findings |= PLANT_VOLTAGE_RANGE;
    if (chain_outside(s->core.y, p->displacementMin, p->displacementMax))
        findings |= PLANT_DISPLACEMENT_RANGE;
    output->flag[OUT_OUT_OF_RANGE] = findings != 0;
    return findings;
}

/* Within the ranges, by the table: a short way, in which nothing is called. */
static int64_t plant_ticks(const void *constants, void *state, const double input[FMU_INPUTS], int64_t count,
                           struct fmu_outputs *output)
{
    const struct chain *chain = constants;
    const double voltage = input[IN_VOLTAGE];
    struct chain_state *s = state;
    double y = s->core.y;
    int64_t done = 0;

    if (!(voltage >= chain->voltage.minimum && voltage <= chain->voltage.maximum) ||
        !it2_is_plain(&chain->core, y))
        return 0;
    for (; done < count; done++) {
        const double next = it2_look_up_step(chain->core.table, y, voltage);
        if (!it2_is_plain(&chain->core, next))
            break;
        y = next;
    }
    if (done == 0)
        return 0;
    s->core.y = y;
    output->real[OUT_DISPLACEMENT] = output->real[OUT_MEASURED] = y;
    output->flag[OUT_OUT_OF_RANGE] = 0;
    return done;
}

static unsigned plant_short_tick(const void *constants, void *state, const void *parameters,
                                 const double input[FMU_INPUTS], double time, struct fmu_outputs *output)
{
    if (plant_ticks(constants, state, input, 1, output) == 1)
        return 0;
    return plant_tick(constants, state, parameters, input, time, output);
}

static void plant_explain(unsigned finding, const void *state, const void *parameters,
                          const double input[FMU_INPUTS], double time, const struct fmu_outputs *output,
                          char *text, size_t size)
{
    const struct chain_parameters *p = parameters;
    const struct chain_state *s = state;

    (void)output;
    if (finding == PLANT_VOLTAGE_RANGE)
        snprintf(text, size,
                 "the voltage left voltageMin..voltageMax, %g to %g V, the range that the "
                 "parameters are valid for: it is %g V at %g s; outOfRange is true as long as it is outside.",
                 p->voltageMin, p->voltageMax, input[IN_VOLTAGE], time);
    else
        snprintf(text, size,
                 "the core's displacement left displacementMin..displacementMax, %g to %g " MICROMETRES ", the "
                 "range that its rules are valid for: it is %g " MICROMETRES " at %g s; outOfRange is true, "
                 "and the model extrapolates, as long as it is outside.",
                 1e6 * p->displacementMin, 1e6 * p->displacementMax, 1e6 * s->core.y, time);
}

static void plant_tick_tangent(const void *constants, const void *state, const double input[FMU_INPUTS],
                               double time, void *d_state, const double d_input[FMU_INPUTS],
                               struct fmu_outputs *d_output)
{
    const struct chain_surroundings around = actuator_surroundings(input, time);
    const struct chain_surroundings d_around = actuator_surroundings_tangent(d_input);
    struct chain_state *d = d_state;
    const struct chain_point next =
        chain_step_tangent(constants, state, input[IN_VOLTAGE], &around, *d, d_input[IN_VOLTAGE], &d_around);

    d_output->real[OUT_DISPLACEMENT] = d_output->real[OUT_MEASURED] = next.output; /* hum adds to it */
    *d = next.state;
}

const struct fmu_model plant_model = {
    ACTUATOR,
    .identifier = "IT2Plant",
    .kind = FMU_PLANT,
    .table_hash = FMU_TABLE_HASH_PLANT,
    .input_start = FMU_PLANT_INPUT_START,
    .diverging = "displacement",
    .prepare = plant_prepare,
    .settle = actuator_settle,
    .start = plant_start,
    .start_tangent = plant_start_tangent,
    .tick = plant_tick,
    .short_tick = plant_short_tick,
    .ticks = plant_ticks,
    .explain = plant_explain,
    .tick_tangent = plant_tick_tangent,
};

/* --- inverse.c --- */

/* The inverse: the chain walked backwards, from a desired displacement to the voltage that yields it. */

enum inverse_finding { INVERSE_OUT_OF_REACH = 1, INVERSE_AMPLIFIER_LIMIT = 2, INVERSE_VOLTAGE_LIMIT = 4 };

static size_t inverse_prepare(void *constants, const void *parameters)
{
    struct chain *chain = constants;

    chain_prepare(chain, parameters);
    chain_pass_by_idle(chain, parameters); /* arrays are not empty, for hosts that know arrays */
    return chain->retraced;
}

/* Before the first tick: the voltage that holds the plant at its initial displacement, so that a
 * master that hands values on one step late starts from rest. */
static bool inverse_start(const void *constants, void *state, const void *parameters,
                          struct fmu_outputs *output, char *message, size_t size)
{
    const struct chain_parameters *p = parameters;

    chain_reset(constants, state, parameters);
    output->real[OUT_VOLTAGE] = chain_equilibrium(constants, state);
    output->flag[OUT_SATURATED] = 0;
    if (isfinite(output->real[OUT_VOLTAGE])) /* a core that a voltage hardly moves may need an infinite one */
        return true;
    snprintf(message, size, "at initialDisplacement, %g m, the output is no finite number",
             p->initialDisplacement);
    return false;
}

static void inverse_start_tangent(const void *constants, const void *state, const void *parameters,
                                  const void *d_parameters, struct fmu_outputs *d_output)
{
    d_output->real[OUT_VOLTAGE] = chain_equilibrium_tangent(constants, state, parameters, d_parameters);
}

static unsigned inverse_tick(const void *constants, void *state, const void *parameters,
                             const double input[FMU_INPUTS], double time, struct fmu_outputs *output)
{
    const struct chain_surroundings around = actuator_surroundings(input, time);
    unsigned limits;
    const double voltage = chain_inverse(constants, state, input[IN_REFERENCE], &around, &limits);
    unsigned findings = 0;

    (void)parameters;
    if (!isfinite(voltage))
        return FMU_NOT_FINITE;
    output->real[OUT_VOLTAGE] = voltage;
    output->flag[OUT_SATURATED] = limits != 0;
    if (limits & CHAIN_REFERENCE_RANGE)
        findings |= INVERSE_OUT_OF_REACH;
    if (limits & CHAIN_AMPLIFIER)
        findings |= INVERSE_AMPLIFIER_LIMIT;
    if (limits & CHAIN_VOLTAGE_RANGE)
        findings |= INVERSE_VOLTAGE_LIMIT;
    return findings;
}

/* Within the ranges, by the table: a short way, in which nothing is called. */
static int64_t inverse_ticks(const void *constants, void *state, const double input[FMU_INPUTS], int64_t count,
                             struct fmu_outputs *output)
{
    const struct chain *chain = constants;
    const double reference = input[IN_REFERENCE];
    struct chain_state *s = state;
    int64_t done = 0;

    if (!it2_is_plain(&chain->core, reference) || !it2_is_plain(&chain->core, s->core.y))
        return 0;
    for (; done < count; done++) {
        const double voltage = it2_look_up_inverse(chain->core.table, s->core.y, reference);
        if (!(voltage >= chain->voltage.minimum && voltage <= chain->voltage.maximum))
            break;
        s->core.y = reference;
        output->real[OUT_VOLTAGE] = voltage;
        output->flag[OUT_SATURATED] = 0;
    }
    return done;
}

static unsigned inverse_short_tick(const void *constants, void *state, const void *parameters,
                                   const double input[FMU_INPUTS], double time, struct fmu_outputs *output)
{
    if (inverse_ticks(constants, state, input, 1, output) == 1)
        return 0;
    return inverse_tick(constants, state, parameters, input, time, output);
}

static void inverse_explain(unsigned finding, const void *state, const void *parameters,
                            const double input[FMU_INPUTS], double time, const struct fmu_outputs *output,
                            char *text, size_t size)
{
    const struct chain_parameters *p = parameters;
    const double reference = 1e6 * input[IN_REFERENCE];
    const double voltage = output->real[OUT_VOLTAGE];

    (void)state;
    if (finding == INVERSE_OUT_OF_REACH)
        snprintf(text, size,
                 "the reference, %g " MICROMETRES
                 " at %g s, is outside displacementMin..displacementMax, %g to "
                 "%g " MICROMETRES "; it is clamped (saturated is true).",
                 reference, time, 1e6 * p->displacementMin, 1e6 * p->displacementMax);
    else if (finding == INVERSE_AMPLIFIER_LIMIT)
        snprintf(text, size,
                 "the reference, %g " MICROMETRES " at %g s, needs a voltage beyond slew.rate or "
                 "saturation.minimum..saturation.maximum; it is clamped to %g V (saturated is true).",
                 reference, time, voltage);
    else
        snprintf(text, size,
                 "the reference, %g " MICROMETRES " at %g s, needs a voltage outside voltageMin..voltageMax, "
                 "%g to %g V; it is clamped to the nearer end (saturated is true).",
                 reference, time, p->voltageMin, p->voltageMax);
}

static void inverse_tick_tangent(const void *constants, const void *state, const double input[FMU_INPUTS],
                                 double time, void *d_state, const double d_input[FMU_INPUTS],
                                 struct fmu_outputs *d_output)
{
    const struct chain_surroundings around = actuator_surroundings(input, time);
    const struct chain_surroundings d_around = actuator_surroundings_tangent(d_input);
    struct chain_state *d = d_state;
    const struct chain_point next = chain_inverse_tangent(constants, state, input[IN_REFERENCE], &around, *d,
                                                          d_input[IN_REFERENCE], &d_around);

    d_output->real[OUT_VOLTAGE] = next.output;
    *d = next.state;
}

const struct fmu_model inverse_model = {
    ACTUATOR,
    .identifier = "IT2Inverse",
    .kind = FMU_INVERSE,
    .table_hash = FMU_TABLE_HASH_INVERSE,
    .input_start = FMU_INVERSE_INPUT_START,
    .diverging = "voltage",
    .prepare = inverse_prepare,
    .settle = actuator_settle,
    .start = inverse_start,
    .start_tangent = inverse_start_tangent,
    .tick = inverse_tick,
    .short_tick = inverse_short_tick,
    .ticks = inverse_ticks,
    .explain = inverse_explain,
    .tick_tangent = inverse_tick_tangent,
};
