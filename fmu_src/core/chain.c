#include "chain.h"

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
