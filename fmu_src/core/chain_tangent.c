/* Directional derivatives: the same walks as those of chain.c, over the stages' tangents. */
#include "chain.h"

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
