/* Directional derivatives. A linear stage is its own: its step and inverse walk the derivatives, and the
 * sensor's zero has no part in them. */
#include "chain.h"

/* From behind the delay to the core's input. */
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

double chain_drive_tangent(const struct chain *chain, struct chain_state *state, double *x,
                           struct chain_state *d, double d_x)
{
    if (chain->effects & CHAIN_DELAY) {
        *x = delay_step(&chain->delay, &state->delay, *x);
        d_x = delay_step(&chain->delay, &d->delay, d_x);
    }
    return to_core_tangent(chain, state, x, d, d_x);
}

static double core_tangent(const struct chain *chain, const struct it2_state *state, double x,
                           struct it2_state *d, double d_x)
{
    const struct it2_partials f = it2_partials(&chain->core, state->y, x);

    d->y = f.dy * d->y + f.dx * d_x;
    return d->y;
}

/* Affine: no state of the plant itself is needed. */
static double respond_affine_tangent(const struct chain *chain, struct chain_state *d, double d_y,
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

double chain_bend_tangent(const struct chain *chain, double y, double d_y)
{
    return chain->effects & CHAIN_NONLINEARITY ? nonlinearity_derivative(&chain->nonlinearity, y) * d_y
                                               : d_y;
}

struct chain_point chain_step_tangent(const struct chain *chain, const struct chain_state *state,
                                      double voltage, const struct chain_surroundings *around,
                                      struct chain_state d_state, double d_voltage,
                                      const struct chain_surroundings *d_around)
{
    struct chain_point d = { .state = d_state };
    struct chain_state copy;

    chain_copy(chain, &copy, state);
    d_voltage = chain_drive_tangent(chain, &copy, &voltage, &d.state, d_voltage);
    d_voltage = core_tangent(chain, &state->core, voltage, &d.state.core, d_voltage);
    d.output = respond_affine_tangent(chain, &d.state, d_voltage, d_around);
    if (chain->effects & CHAIN_NONLINEARITY) {
        const double y = it2_step(&chain->core, &copy.core, voltage);
        d.output =
            chain_bend_tangent(chain, chain_respond_affine(chain, &copy, y, around), d.output);
    }
    return d;
}

/* From what is aimed at to the core's target. */
static double core_target_tangent(const struct chain *chain, struct chain_state *d, double y, double d_y,
                                  const struct chain_surroundings *d_around)
{
    if (chain->effects & CHAIN_NONLINEARITY)
        d_y /= nonlinearity_derivative(&chain->nonlinearity,
                                       nonlinearity_inverse(&chain->nonlinearity, y));
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

/* A value and its derivative. */
struct both {
    double value;
    double d;
};

static struct both limited(const struct saturation_parameters *limits, struct both x)
{
    return (struct both){ saturation_inverse(limits, x.value),
                          saturation_step_tangent(limits, x.value, x.d) };
}

/* What the slew limit passes on; what the inverse gives is that within voltageMin..voltageMax. */
static struct both within_limits_tangent(const struct chain *chain, const struct chain_state *state,
                                         struct both x, struct chain_state *d)
{
    if (chain->effects & CHAIN_SATURATION)
        x = limited(&chain->saturation, x);
    x = limited(&chain->voltage, x);
    if (chain->effects & CHAIN_SLEW) {
        struct slew_state copy = state->slew;
        x.d = slew_step_tangent(&chain->slew, &state->slew, x.value, &d->slew, x.d);
        x.value = slew_inverse(&chain->slew, &copy, x.value);
    }
    return x;
}

static void arrive_tangent(struct chain_state *d)
{
    d->reached.core = d->core;
    d->reached.lag = d->lag;
    d->reached.resonance = d->resonance;
}

/* As follow_plant of chain.c. */
static void follow_plant_tangent(const struct chain *chain, const struct chain_state *state, struct both x,
                                 struct chain_state *d, const struct chain_surroundings *d_around)
{
    struct lag_state lag = state->reached.lag;
    struct play_state play = state->play;

    if (chain->effects & CHAIN_SATURATION)
        x = limited(&chain->saturation, x);
    if (chain->effects & CHAIN_LAG) {
        x.value = lag_step(&chain->lag, &lag, x.value);
        x.d = lag_step(&chain->lag, &d->reached.lag, x.d);
    }
    if (chain->effects & CHAIN_PLAY) {
        x.d = play_step_tangent(&chain->play, &state->play, x.value, &d->play, x.d);
        x.value = play_step(&chain->play, &play, x.value);
    }
    double d_y = core_tangent(chain, &state->reached.core, x.value, &d->reached.core, x.d);
    if (chain->effects & CHAIN_LOAD)
        d_y = load_step(&chain->load, d_y, d_around->force);
    if (chain->effects & CHAIN_CREEP)
        d_y = creep_step(&chain->creep, &d->creep, d_y);
    if (chain->effects & CHAIN_RESONANCE)
        resonance_step(&chain->resonance, &d->reached.resonance, d_y);
}

/* As follow_aim of chain.c. */
static void follow_aim_tangent(const struct chain *chain, const struct chain_state *state, struct both x,
                               double d_aim, struct chain_state *d,
                               const struct chain_surroundings *d_around)
{
    if (chain->effects & CHAIN_PLAY)
        play_step_tangent(&chain->play, &state->play, x.value, &d->play, x.d);
    if (chain->effects & CHAIN_LOAD)
        d_aim = load_step(&chain->load, d_aim, d_around->force);
    if (chain->effects & CHAIN_CREEP)
        creep_step(&chain->creep, &d->creep, d_aim);
}

/* `after` is what chain_inverse leaves of `state`: there is the core's aim. */
static double inverse_with_effects_tangent(const struct chain *chain, const struct chain_state *state,
                                           const struct chain_state *after, unsigned limits,
                                           double displacement, double d_displacement,
                                           struct chain_state *d,
                                           const struct chain_surroundings *d_around)
{
    const double d_aim = core_target_tangent(chain, d, displacement, d_displacement, d_around);
    struct both x = { it2_solve(&chain->core, state->core.y, after->core.y), 0.0 };

    x.d = core_inverse_tangent(chain, &state->core, x.value, &d->core, d_aim);
    if (chain->effects & CHAIN_PLAY) {
        x.value = play_solve(&chain->play, &state->play, x.value);
        x.d = play_solve_tangent(&chain->play, &state->play, x.value, &d->play, x.d);
    }
    struct both wanted = x;
    if (chain->effects & CHAIN_LAG) {
        struct lag_state lag = state->lag;
        wanted.value = lag_inverse(&chain->lag, &lag, x.value);
        wanted.d = lag_inverse(&chain->lag, &d->lag, x.d);
    }
    const struct both passed = within_limits_tangent(chain, state, wanted, d);
    if (chain_is_astray(state) || limits & (CHAIN_AMPLIFIER | CHAIN_VOLTAGE_RANGE))
        follow_plant_tangent(chain, state, passed, d, d_around);
    else
        follow_aim_tangent(chain, state, x, d_aim, d, d_around);
    if (!chain_is_astray(after))
        arrive_tangent(d);
    return limited(&chain->voltage, passed).d;
}

static double inverse_of_core_tangent(const struct chain *chain, const struct it2_state *state,
                                      double displacement, double d_displacement, struct it2_state *d)
{
    const double wanted = it2_solve(&chain->core, state->y, displacement);
    const double voltage = saturation_inverse(&chain->voltage, wanted);

    if (voltage == wanted)
        return core_inverse_tangent(chain, state, wanted, d, d_displacement);
    core_tangent(chain, state, voltage, d, 0.0);
    return 0.0;
}

struct chain_point chain_inverse_tangent(const struct chain *chain, const struct chain_state *state,
                                         double displacement, const struct chain_surroundings *around,
                                         struct chain_state d_state, double d_displacement,
                                         const struct chain_surroundings *d_around)
{
    struct chain_point d = { .state = d_state };
    struct it2_range reach = chain->displacement;
    struct chain_state after;
    unsigned limits;

    chain_copy(chain, &after, state);
    chain_inverse(chain, &after, displacement, around, &limits);
    if (limits & CHAIN_REFERENCE_RANGE) {
        displacement = displacement < reach.minimum ? reach.minimum : reach.maximum;
        d_displacement = 0.0;
    }
    d.output = chain->effects
                   ? inverse_with_effects_tangent(chain, state, &after, limits, displacement,
                                                  d_displacement, &d.state, d_around)
                   : inverse_of_core_tangent(chain, &state->core, displacement, d_displacement,
                                             &d.state.core);
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

/* Derivative of what chain_reset_response returns. */
static double core_rest_tangent(const struct chain *chain, const struct chain_parameters *parameters,
                                const struct chain_parameters *d_parameters)
{
    const double d_zero = d_parameters->displacementZero;
    double y = parameters->initialDisplacement;
    double d = d_parameters->initialDisplacement;

    if (chain->effects & CHAIN_NONLINEARITY) {
        y = nonlinearity_inverse(&chain->nonlinearity, y);
        d = nonlinearity_inverse_tangent(&chain->nonlinearity, y, &d_parameters->nonlinearity, d_zero, d);
    }
    if (chain->effects & CHAIN_CREEP) {
        struct creep_state state;
        y = creep_reset(&chain->creep, &state, y - chain->zero, parameters->initialCreep);
        d = d_zero + creep_reset_tangent(&chain->creep, y, parameters->initialCreep, d_parameters->creep,
                                         d - d_zero, d_parameters->initialCreep);
    }
    return d;
}

/* Of the nearest value to x within limits that move, too. */
static struct both limited_by(const struct saturation_parameters *limits, struct both x, double d_minimum,
                              double d_maximum)
{
    const double d = x.value < limits->minimum ? d_minimum : x.value > limits->maximum ? d_maximum : x.d;

    return (struct both){ saturation_inverse(limits, x.value), d };
}

double chain_equilibrium_tangent(const struct chain *chain, const struct chain_state *state,
                                 const struct chain_parameters *parameters,
                                 const struct chain_parameters *d_parameters)
{
    const double y = state->core.y;
    struct both x = { chain_hold(chain, state), core_rest_tangent(chain, parameters, d_parameters) };

    x.d = core_equilibrium_tangent(chain, y, x.d, d_parameters);
    if (chain->effects & CHAIN_PLAY)
        x.d = play_reset_tangent(&chain->play, it2_solve(&chain->core, y, y),
                                 chain_history(parameters), d_parameters->play, x.d,
                                 chain_history(d_parameters));
    if (chain->effects & CHAIN_SATURATION)
        x = limited_by(&chain->saturation, x, d_parameters->saturation.minimum,
                       d_parameters->saturation.maximum);
    return limited_by(&chain->voltage, x, d_parameters->voltageMin, d_parameters->voltageMax).d;
}
