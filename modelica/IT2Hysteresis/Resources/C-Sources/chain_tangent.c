/* Directional derivatives. A linear stage is its own: its step and inverse walk the derivatives. */
#include "chain.h"

/* Advances the derivatives `d` of `state` by a step with `x`, and `state` with it. */
static double to_core_tangent(const struct chain *chain, struct chain_state *state, double *x,
                              struct chain_state *d, double d_x)
{
    if (chain->effects & CHAIN_SLEW) {
        d_x = slew_step_tangent(&chain->slew, &state->slew, *x, &d->slew, d_x);
        *x = slew_step(&chain->slew, &state->slew, *x);
    }
    if (chain->effects & CHAIN_SATURATION) {
        d_x = saturation_step_tangent(&chain->saturation, *x, d_x);
        *x = saturation_step(&chain->saturation, *x);
    }
    if (chain->effects & CHAIN_LAG) {
        d_x = lag_step(&chain->lag, &d->lag, d_x);
        *x = lag_step(&chain->lag, &state->lag, *x);
    }
    if (chain->effects & CHAIN_PLAY) {
        d_x = play_step_tangent(&chain->play, &state->play, *x, &d->play, d_x);
        *x = play_step(&chain->play, &state->play, *x);
    }
    return d_x;
}

static double core_tangent(const struct chain *chain, const struct it2_state *state, double x,
                           struct it2_state *d, double d_x)
{
    const struct it2_partials f = it2_partials(&chain->core, state->y, x);

    d->y = f.dy * d->y + f.dx * d_x;
    return d->y;
}

/* Linear but for the drift's offset: no state of the plant itself is needed. */
static double from_core_tangent(const struct chain *chain, struct chain_state *d, double d_y,
                                const struct chain_surroundings *d_around)
{
    if (chain->effects & CHAIN_LOAD)
        d_y = load_step(&chain->load, d_y, d_around->force);
    if (chain->effects & CHAIN_CREEP)
        d_y = creep_step(&chain->creep, &d->creep, d_y);
    if (chain->effects & CHAIN_RESONANCE)
        d_y = resonance_step(&chain->resonance, &d->resonance, d_y);
    if (chain->effects & CHAIN_DRIFT)
        d_y = drift_step_tangent(&chain->drift, d_y, d_around->temperature);
    return d_y;
}

struct chain_point chain_step_tangent(const struct chain *chain, const struct chain_state *state,
                                      double voltage, const struct chain_surroundings *around,
                                      struct chain_state d_state, double d_voltage,
                                      const struct chain_surroundings *d_around)
{
    struct chain_point d = { .state = d_state };
    struct chain_state copy;

    (void)around; /* its effects are linear */
    chain_copy(chain, &copy, state);
    if (chain->effects & CHAIN_DELAY) {
        voltage = delay_step(&chain->delay, &copy.delay, voltage);
        d_voltage = delay_step(&chain->delay, &d.state.delay, d_voltage);
    }
    d_voltage = to_core_tangent(chain, &copy, &voltage, &d.state, d_voltage);
    d_voltage = core_tangent(chain, &state->core, voltage, &d.state.core, d_voltage);
    d.output = from_core_tangent(chain, &d.state, d_voltage, d_around);
    return d;
}

/* From what is aimed at to the core's target. */
static double core_target_tangent(const struct chain *chain, struct chain_state *d, double d_y,
                                  const struct chain_surroundings *d_around)
{
    if (chain->effects & CHAIN_DRIFT)
        d_y = drift_inverse_tangent(&chain->drift, d_y, d_around->temperature);
    if (chain->effects & CHAIN_RESONANCE)
        d_y = resonance_inverse(&chain->resonance, &d->resonance, d_y);
    if (chain->effects & CHAIN_CREEP)
        d_y = creep_solve(&chain->creep, &d->creep, d_y);
    if (chain->effects & CHAIN_LOAD)
        d_y = load_inverse(&chain->load, d_y, d_around->force);
    return d_y;
}

/* From y = F(y_previous, x): dx = (dy - dF/dy_previous dy_previous) / (dF/dx). */
static double core_inverse_tangent(const struct chain *chain, const struct it2_state *state, double x,
                                   struct it2_state *d, double d_y)
{
    const struct it2_partials f = it2_partials(&chain->core, state->y, x);
    const double d_x = (d_y - f.dy * d->y) / f.dx;

    d->y = d_y;
    return d_x;
}

static double within_limits_tangent(const struct chain *chain, const struct chain_state *state,
                                    double *x, struct chain_state *d, double d_x)
{
    if (chain->effects & CHAIN_SATURATION) {
        d_x = saturation_step_tangent(&chain->saturation, *x, d_x);
        *x = saturation_inverse(&chain->saturation, *x);
    }
    if (chain->effects & CHAIN_SLEW) {
        struct slew_state copy = state->slew;
        d_x = slew_step_tangent(&chain->slew, &state->slew, *x, &d->slew, d_x);
        *x = slew_inverse(&chain->slew, &copy, *x);
    }
    return d_x;
}

/* As follow_plant of chain.c. */
static void follow_plant_tangent(const struct chain *chain, const struct chain_state *state,
                                 double voltage, double x, struct chain_state *d, double d_voltage,
                                 double d_x, double d_aim, const struct chain_surroundings *d_around)
{
    const bool limited = chain->effects & (CHAIN_SLEW | CHAIN_SATURATION);
    struct lag_state lag = state->reached.lag;
    struct play_state play = state->play;

    if (chain->effects & CHAIN_SATURATION) {
        d_voltage = saturation_step_tangent(&chain->saturation, voltage, d_voltage);
        voltage = saturation_step(&chain->saturation, voltage);
    }
    if (limited) {
        const bool lags = chain->effects & CHAIN_LAG;
        x = lags ? lag_step(&chain->lag, &lag, voltage) : voltage;
        d_x = lags ? lag_step(&chain->lag, &d->reached.lag, d_voltage) : d_voltage;
    }
    if (chain->effects & CHAIN_PLAY) {
        d_x = play_step_tangent(&chain->play, &state->play, x, &d->play, d_x);
        x = play_step(&chain->play, &play, x);
    }
    if (limited)
        d_aim = core_tangent(chain, &state->reached.core, x, &d->reached.core, d_x);
    if (chain->effects & CHAIN_LOAD)
        d_aim = load_step(&chain->load, d_aim, d_around->force);
    if (chain->effects & CHAIN_CREEP)
        creep_step(&chain->creep, &d->creep, d_aim);
}

/* The walk of chain_inverse. Its values: first the core's aim, which chain_inverse leaves behind. */
struct chain_point chain_inverse_tangent(const struct chain *chain, const struct chain_state *state,
                                         double displacement, const struct chain_surroundings *around,
                                         struct chain_state d_state, double d_displacement,
                                         const struct chain_surroundings *d_around)
{
    struct chain_point d = { .state = d_state };
    struct chain_state after;
    unsigned limits;

    chain_copy(chain, &after, state);
    chain_inverse(chain, &after, displacement, around, &limits);
    const bool cut = limits & CHAIN_CORE_RANGE;
    const double d_target = core_target_tangent(chain, &d.state, d_displacement, d_around);
    const double d_aim = cut ? 0.0 : d_target;
    double x = it2_solve(&chain->core, state->core.y, after.core.y);
    double d_x = core_inverse_tangent(chain, &state->core, x, &d.state.core, d_aim);
    if (chain->effects & CHAIN_PLAY) {
        x = play_solve(&chain->play, &state->play, x);
        d_x = play_solve_tangent(&chain->play, &state->play, x, &d.state.play, d_x);
    }
    double voltage = x;
    d.output = d_x;
    if (chain->effects & CHAIN_LAG) {
        struct lag_state lag = state->lag;
        voltage = lag_inverse(&chain->lag, &lag, x);
        d.output = lag_inverse(&chain->lag, &d.state.lag, d_x);
    }
    d.output = within_limits_tangent(chain, state, &voltage, &d.state, d.output);
    follow_plant_tangent(chain, state, voltage, x, &d.state, d.output, d_x, d_aim, d_around);
    return d;
}

/* From y = F(y, x, p): dx = (dy - dF/dy dy - dF/dp dp) / (dF/dx). */
static double core_equilibrium_tangent(const struct chain *chain, double y, double d_y,
                                       const struct chain_parameters *d_parameters)
{
    double gradient[IT2_RULE_PARAMETERS * IT2_MAX_RULES];
    struct it2_partials f;
    double d = d_y;

    it2_gradient(&chain->core, y, it2_solve(&chain->core, y, y), gradient, &f);
    d -= f.dy * d_y;
    d -= f.end * (y < chain->core.lower.y ? d_parameters->displacementMin : d_parameters->displacementMax);
    for (int l = 0; l < chain->core.rules; l++) {
        const double *by_rule = gradient + IT2_RULE_PARAMETERS * l;
        const struct it2_rule *rule = &d_parameters->rule[l];
        d -= by_rule[0] * rule->sigmaLower + by_rule[1] * rule->sigmaUpper + by_rule[2] * rule->centre +
             by_rule[3] * rule->q1 + by_rule[4] * rule->q2 + by_rule[5] * rule->q3;
    }
    return d / f.dx;
}

double chain_equilibrium_tangent(const struct chain *chain, const struct chain_state *state,
                                 const struct chain_parameters *parameters,
                                 const struct chain_parameters *d_parameters)
{
    const double y = state->core.y;
    double d = d_parameters->initialDisplacement;

    if (chain->effects & CHAIN_CREEP)
        d = creep_reset_tangent(&chain->creep, y, parameters->initialCreep, d_parameters->creep, d,
                                d_parameters->initialCreep);
    d = core_equilibrium_tangent(chain, y, d, d_parameters);
    if (chain->effects & CHAIN_PLAY)
        d = play_reset_tangent(&chain->play, it2_solve(&chain->core, y, y),
                               chain_history(parameters), d_parameters->play, d,
                               chain_history(d_parameters));
    if (!(chain->effects & CHAIN_SATURATION))
        return d;
    struct chain unlimited = *chain;
    unlimited.effects &= ~(unsigned)CHAIN_SATURATION;
    const double x = chain_equilibrium(&unlimited, state);
    return x < chain->saturation.minimum   ? d_parameters->saturation.minimum
           : x > chain->saturation.maximum ? d_parameters->saturation.maximum
                                           : d;
}

double chain_measure_tangent(const struct chain *chain, double displacement, double d_displacement)
{
    if (chain->reading & CHAIN_NONLINEARITY)
        return nonlinearity_derivative(&chain->nonlinearity, displacement) * d_displacement;
    return d_displacement;
}
