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

static double core_tangent(const struct chain *chain, const struct chain_state *state, double x,
                           struct chain_state *d, double d_x)
{
    const struct it2_partials f = it2_partials(&chain->core, state->core.y, x);

    d->core.y = f.dy * d->core.y + f.dx * d_x;
    return d->core.y;
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

/* Needs the voltage behind the delay. */
static double step_tangent(const struct chain *chain, const struct chain_state *state, double x,
                           struct chain_state *d, double d_x,
                           const struct chain_surroundings *d_around)
{
    struct chain_state copy;

    chain_copy(chain, &copy, state);
    d_x = to_core_tangent(chain, &copy, &x, d, d_x);
    return from_core_tangent(chain, d, core_tangent(chain, state, x, d, d_x), d_around);
}

struct chain_point chain_step_tangent(const struct chain *chain, const struct chain_state *state,
                                      double voltage, const struct chain_surroundings *around,
                                      struct chain_state d_state, double d_voltage,
                                      const struct chain_surroundings *d_around)
{
    struct chain_point d = { .state = d_state };

    (void)around; /* its effects are linear */
    if (chain->effects & CHAIN_DELAY) {
        struct delay_state copy = state->delay;
        voltage = delay_step(&chain->delay, &copy, voltage);
        d_voltage = delay_step(&chain->delay, &d.state.delay, d_voltage);
    }
    d.output = step_tangent(chain, state, voltage, &d.state, d_voltage, d_around);
    return d;
}

static double back_to_core_tangent(const struct chain *chain, struct chain_state *d, double d_y,
                                   const struct chain_surroundings *d_around)
{
    if (chain->effects & CHAIN_DRIFT)
        d_y = drift_inverse_tangent(&chain->drift, d_y, d_around->temperature);
    if (chain->effects & CHAIN_RESONANCE)
        d_y = resonance_inverse(&chain->resonance, &d->resonance, d_y);
    if (chain->effects & CHAIN_CREEP)
        d_y = creep_inverse(&chain->creep, &d->creep, d_y);
    if (chain->effects & CHAIN_LOAD)
        d_y = load_inverse(&chain->load, d_y, d_around->force);
    return d_y;
}

/* From y = F(y_previous, x): dx = (dy - dF/dy_previous dy_previous) / (dF/dx). */
static double core_inverse_tangent(const struct chain *chain, const struct chain_state *state,
                                   double x, struct chain_state *d, double d_y)
{
    const struct it2_partials f = it2_partials(&chain->core, state->core.y, x);
    const double d_x = (d_y - f.dy * d->core.y) / f.dx;

    d->core.y = d_y;
    return d_x;
}

/* Advances `state` and `d` from the core's input to the voltage that is wanted. */
static double back_to_amplifier_tangent(const struct chain *chain, struct chain_state *state, double *x,
                                        struct chain_state *d, double d_x)
{
    if (chain->effects & CHAIN_PLAY) {
        d_x = play_inverse_tangent(&chain->play, &state->play, *x, &d->play, d_x);
        *x = play_inverse(&chain->play, &state->play, *x);
    }
    if (chain->effects & CHAIN_LAG) {
        d_x = lag_inverse(&chain->lag, &d->lag, d_x);
        *x = lag_inverse(&chain->lag, &state->lag, *x);
    }
    return d_x;
}

static double within_limits_tangent(const struct chain *chain, struct chain_state *state, double *x,
                                    struct chain_state *d, double d_x)
{
    if (chain->effects & CHAIN_SATURATION) {
        d_x = saturation_step_tangent(&chain->saturation, *x, d_x);
        *x = saturation_inverse(&chain->saturation, *x);
    }
    if (chain->effects & CHAIN_SLEW) {
        d_x = slew_step_tangent(&chain->slew, &state->slew, *x, &d->slew, d_x);
        *x = slew_inverse(&chain->slew, &state->slew, *x);
    }
    return d_x;
}

/* The walk of chain_inverse, with its derivatives. */
struct chain_point chain_inverse_tangent(const struct chain *chain, const struct chain_state *state,
                                         double displacement, const struct chain_surroundings *around,
                                         struct chain_state d_state, double d_displacement,
                                         const struct chain_surroundings *d_around)
{
    struct chain_point d = { .state = d_state };
    struct chain_state copy = *state;
    const double target = chain_core_target(chain, &copy, displacement, around);
    const double d_target = back_to_core_tangent(chain, &d.state, d_displacement, d_around);
    const double aim = clamp(target, chain->displacement.minimum, chain->displacement.maximum);
    double voltage = it2_solve(&chain->core, state->core.y, aim);

    d.output = core_inverse_tangent(chain, state, voltage, &d.state, aim == target ? d_target : 0.0);
    d.output = back_to_amplifier_tangent(chain, &copy, &voltage, &d.state, d.output);
    const double wanted = voltage;
    d.output = within_limits_tangent(chain, &copy, &voltage, &d.state, d.output);
    if (chain->effects && (aim != target || voltage != wanted)) {
        d.state = d_state;
        step_tangent(chain, state, voltage, &d.state, d.output, d_around);
    }
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
    for (int l = 0; l < chain->core.rules; l++) {
        const double *by_rule = gradient + IT2_RULE_PARAMETERS * l;
        const struct it2_rule *rule = &d_parameters->rule[l];
        d -= by_rule[0] * rule->sigmaLower + by_rule[1] * rule->sigmaUpper + by_rule[2] * rule->centre +
             by_rule[3] * rule->q1 + by_rule[4] * rule->q2 + by_rule[5] * rule->q3;
    }
    return d / f.dx;
}

double chain_equilibrium_tangent(const struct chain *chain, const struct chain_state *state,
                                 const struct chain_parameters *d_parameters)
{
    const double y = state->core.y;
    double d = d_parameters->initialDisplacement;

    if (chain->effects & CHAIN_CREEP)
        d = creep_reset_tangent(&chain->creep, y, d_parameters->creep, d);
    d = core_equilibrium_tangent(chain, y, d, d_parameters);
    if (chain->effects & CHAIN_PLAY)
        d = play_reset_tangent(&chain->play, it2_solve(&chain->core, y, y), d_parameters->play, d);
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
