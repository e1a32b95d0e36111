#include "chain.h"

#include <float.h>
#include <math.h>

/* Values of a range are the same if no more than this share of it is between them, or last digits. */
#define SAME 1e-10
#define LAST_DIGITS (64.0 * DBL_EPSILON)

/* --- set up ------------------------------------------------------------------------------------ */

static unsigned effects_of(const struct chain_parameters *p)
{
    return (p->delay.time > 0.0 ? CHAIN_DELAY : 0u) | (p->slew.rate > 0.0 ? CHAIN_SLEW : 0u) |
           (saturation_is_on(&p->saturation) ? CHAIN_SATURATION : 0u) |
           (p->lag.timeConstant > 0.0 ? CHAIN_LAG : 0u) | (p->playCount > 0 ? CHAIN_PLAY : 0u) |
           (p->load.compliance != 0.0 ? CHAIN_LOAD : 0u) | (p->creepCount > 0 ? CHAIN_CREEP : 0u) |
           (p->resonance.frequency > 0.0 ? CHAIN_RESONANCE : 0u) |
           (drift_is_on(&p->drift) ? CHAIN_DRIFT : 0u) |
           (nonlinearity_is_on(&p->nonlinearity) ? CHAIN_NONLINEARITY : 0u) |
           (p->hum.amplitude > 0.0 ? CHAIN_HUM : 0u);
}

void chain_prepare(struct chain *chain, const struct chain_parameters *p)
{
    const unsigned effects = effects_of(p);

    it2_prepare(&chain->core, p->rule, p->ruleCount,
                (struct it2_range){ p->displacementMin, p->displacementMax });
    chain->displacement = (struct it2_range){ p->displacementMin, p->displacementMax };
    chain->voltage = (struct saturation_parameters){ p->voltageMin, p->voltageMax };
    chain->zero = p->displacementZero;
    chain->effects = effects & ~(unsigned)CHAIN_READING;
    chain->reading = effects & CHAIN_READING;
    delay_prepare(&chain->delay, &p->delay, p->sampleTime);
    slew_prepare(&chain->slew, &p->slew, p->sampleTime);
    chain->saturation = p->saturation;
    play_prepare(&chain->play, p->play, p->playCount);
    chain->load = p->load;
    creep_prepare(&chain->creep, p->creep, p->creepCount, p->sampleTime);
    chain->drift = p->drift;
    nonlinearity_prepare(&chain->nonlinearity, &p->nonlinearity, p->displacementZero);
    chain->hum = p->hum;
    if (effects & CHAIN_LAG)
        lag_prepare(&chain->lag, &p->lag, p->sampleTime);
    if (effects & CHAIN_RESONANCE)
        resonance_prepare(&chain->resonance, &p->resonance, p->sampleTime);
}

/* The plant is where it was aimed at. */
static void arrive(struct chain_state *state)
{
    state->reached.core = state->core;
    state->reached.lag = state->lag;
    state->reached.resonance = state->resonance;
}

double chain_reset_response(const struct chain *chain, struct chain_state *state,
                            const struct chain_parameters *parameters)
{
    double y = parameters->initialDisplacement;

    if (chain->effects & CHAIN_NONLINEARITY)
        y = nonlinearity_inverse(&chain->nonlinearity, y);
    if (chain->effects & CHAIN_RESONANCE)
        resonance_reset(&state->resonance, y);
    if (chain->effects & CHAIN_CREEP)
        y = chain->zero + creep_reset(&chain->creep, &state->creep, y - chain->zero,
                                      parameters->initialCreep);
    return y;
}

void chain_reset(const struct chain *chain, struct chain_state *state,
                 const struct chain_parameters *parameters)
{
    *state = (struct chain_state){ 0 };
    const double y = chain_reset_response(chain, state, parameters);
    it2_reset(&state->core, y);
    if (!chain->effects)
        return;
    const double x = play_reset(&chain->play, &state->play, it2_solve(&chain->core, y, y),
                                chain_history(parameters));
    lag_reset(&state->lag, x);
    slew_reset(&state->slew, x);
    delay_reset(&state->delay, x);
    arrive(state);
}

/* --- forwards ---------------------------------------------------------------------------------- */

double chain_drive(const struct chain *chain, struct chain_state *state, double x)
{
    if (chain->effects & CHAIN_DELAY)
        x = delay_step(&chain->delay, &state->delay, x);
    if (chain->effects & CHAIN_SLEW)
        x = slew_step(&chain->slew, &state->slew, x);
    if (chain->effects & CHAIN_SATURATION)
        x = saturation_step(&chain->saturation, x);
    if (chain->effects & CHAIN_LAG)
        x = lag_step(&chain->lag, &state->lag, x);
    if (chain->effects & CHAIN_PLAY)
        x = play_step(&chain->play, &state->play, x);
    return x;
}

/* Creep acts on what lies above the sensor's zero. */
static double creep_above_zero(const struct chain *chain, struct chain_state *state, double y)
{
    return chain->zero + creep_step(&chain->creep, &state->creep, y - chain->zero);
}

double chain_respond_affine(const struct chain *chain, struct chain_state *state, double y,
                            const struct chain_surroundings *around)
{
    if (chain->effects & CHAIN_LOAD)
        y = load_step(&chain->load, y, around->force);
    if (chain->effects & CHAIN_CREEP)
        y = creep_above_zero(chain, state, y);
    if (chain->effects & CHAIN_RESONANCE)
        y = resonance_step(&chain->resonance, &state->resonance, y);
    if (chain->effects & CHAIN_DRIFT)
        y = drift_step(&chain->drift, y, around->temperature, around->time);
    return y;
}

double chain_bend(const struct chain *chain, double y)
{
    return chain->effects & CHAIN_NONLINEARITY ? nonlinearity_step(&chain->nonlinearity, y) : y;
}

double chain_respond(const struct chain *chain, struct chain_state *state, double y,
                     const struct chain_surroundings *around)
{
    return chain_bend(chain, chain_respond_affine(chain, state, y, around));
}

double chain_step_effects(const struct chain *chain, struct chain_state *state, double voltage,
                          const struct chain_surroundings *around)
{
    const double x = chain_drive(chain, state, voltage);
    return chain_respond(chain, state, it2_step(&chain->core, &state->core, x), around);
}

double chain_measure_effects(const struct chain *chain, double displacement, double time)
{
    return chain->reading & CHAIN_HUM ? hum_step(&chain->hum, displacement, time) : displacement;
}

/* --- backwards --------------------------------------------------------------------------------- */

/* What the core has to reach. Drift is that of the time when the voltage arrives. */
static double core_target(const struct chain *chain, struct chain_state *state, double y,
                          const struct chain_surroundings *around)
{
    if (chain->effects & CHAIN_NONLINEARITY)
        y = nonlinearity_inverse(&chain->nonlinearity, y);
    if (chain->effects & CHAIN_DRIFT)
        y = drift_inverse(&chain->drift, y, around->temperature, around->time + chain->delay.time);
    if (chain->effects & CHAIN_RESONANCE)
        y = resonance_inverse(&chain->resonance, &state->resonance, y);
    if (chain->effects & CHAIN_CREEP)
        y = chain->zero + creep_solve(&chain->creep, &state->creep, y - chain->zero);
    if (chain->effects & CHAIN_LOAD)
        y = load_inverse(&chain->load, y, around->force);
    return y;
}

static double within_reach(const struct chain *chain, double displacement)
{
    return fmin(fmax(displacement, chain->displacement.minimum), chain->displacement.maximum);
}

static double within_voltages(const struct chain *chain, double x)
{
    return clamp(x, chain->voltage.minimum, chain->voltage.maximum);
}

static bool is_near(double a, double b, double low, double high)
{
    return fabs(a - b) <= SAME * (high - low) + LAST_DIGITS * fmax(fabs(low), fabs(high));
}

static bool same_voltage(const struct chain *chain, double a, double b)
{
    return is_near(a, b, chain->voltage.minimum, chain->voltage.maximum);
}

/* The nearest voltage that may be given. `*passed` is what the slew limit makes of it: something else only
 * while the amplifier, at rest at the start, is farther out of the range than it can come back in a tick. */
static double within_limits(const struct chain *chain, struct chain_state *state, double wanted,
                            double *passed, unsigned *limits)
{
    const double possible =
        chain->effects & CHAIN_SATURATION ? saturation_inverse(&chain->saturation, wanted) : wanted;
    const double allowed = within_voltages(chain, possible);

    *passed = chain->effects & CHAIN_SLEW ? slew_inverse(&chain->slew, &state->slew, allowed) : allowed;
    const double voltage = within_voltages(chain, *passed);
    if (voltage == wanted && possible == wanted)
        return voltage;
    if (!same_voltage(chain, possible, wanted) || !same_voltage(chain, *passed, allowed))
        *limits |= CHAIN_AMPLIFIER;
    if (!same_voltage(chain, allowed, possible) || !same_voltage(chain, voltage, *passed))
        *limits |= CHAIN_VOLTAGE_RANGE;
    return voltage;
}

bool chain_is_astray(const struct chain_state *state)
{
    const struct chain_reached *reached = &state->reached;

    return reached->core.y != state->core.y || reached->lag.y != state->lag.y ||
           reached->resonance.y1 != state->resonance.y1 || reached->resonance.y2 != state->resonance.y2;
}

static bool is_back(const struct chain *chain, const struct chain_state *state)
{
    const struct chain_reached *reached = &state->reached;
    const double low = chain->displacement.minimum, high = chain->displacement.maximum;

    return is_near(reached->core.y, state->core.y, low, high) &&
           same_voltage(chain, reached->lag.y, state->lag.y) &&
           is_near(reached->resonance.y1, state->resonance.y1, low, high) &&
           is_near(reached->resonance.y2, state->resonance.y2, low, high);
}

/* The plant's way from what its slew limit lets through; returns whether it is where it was aimed at. */
static bool follow_plant(const struct chain *chain, struct chain_state *state, double x,
                         const struct chain_surroundings *around)
{
    struct chain_reached *reached = &state->reached;

    if (chain->effects & CHAIN_SATURATION) /* it may rest beyond its limits */
        x = saturation_step(&chain->saturation, x);
    if (chain->effects & CHAIN_LAG)
        x = lag_step(&chain->lag, &reached->lag, x);
    if (chain->effects & CHAIN_PLAY)
        x = play_step(&chain->play, &state->play, x);
    double y = it2_step(&chain->core, &reached->core, x);
    if (chain->effects & CHAIN_LOAD)
        y = load_step(&chain->load, y, around->force);
    if (chain->effects & CHAIN_CREEP)
        y = creep_above_zero(chain, state, y);
    if (chain->effects & CHAIN_RESONANCE)
        resonance_step(&chain->resonance, &reached->resonance, y);
    if (!is_back(chain, state))
        return false;
    arrive(state);
    return true;
}

/* The plant's way where nothing is cut off. `x` and `aim` are what is aimed at before and behind the core. */
static void follow_aim(const struct chain *chain, struct chain_state *state, double x, double aim,
                       const struct chain_surroundings *around)
{
    if (chain->effects & CHAIN_PLAY)
        play_step(&chain->play, &state->play, x);
    if (chain->effects & CHAIN_LOAD)
        aim = load_step(&chain->load, aim, around->force);
    if (chain->effects & CHAIN_CREEP)
        creep_above_zero(chain, state, aim);
    arrive(state);
}

static double inverse_with_effects(const struct chain *chain, struct chain_state *state,
                                   double displacement, const struct chain_surroundings *around,
                                   unsigned *limits)
{
    const bool astray = chain_is_astray(state);
    const double aim = core_target(chain, state, displacement, around);
    double x = it2_inverse(&chain->core, &state->core, aim);
    double passed;
    unsigned cut = 0;

    if (chain->effects & CHAIN_PLAY)
        x = play_solve(&chain->play, &state->play, x);
    const double wanted = chain->effects & CHAIN_LAG ? lag_inverse(&chain->lag, &state->lag, x) : x;
    const double voltage = within_limits(chain, state, wanted, &passed, &cut);
    *limits |= cut;
    if (!astray && !cut)
        follow_aim(chain, state, x, aim, around);
    else if (!follow_plant(chain, state, passed, around))
        *limits |= CHAIN_RETURNING;
    return voltage;
}

/* Without effects; goes on from what the plant reaches. */
static double inverse_of_core(const struct chain *chain, struct chain_state *state, double displacement,
                              unsigned *limits)
{
    const double before = state->core.y;
    const double wanted = it2_inverse(&chain->core, &state->core, displacement);
    const double voltage = within_voltages(chain, wanted);

    if (voltage == wanted)
        return voltage;
    it2_reset(&state->core, before);
    it2_step(&chain->core, &state->core, voltage);
    if (!same_voltage(chain, voltage, wanted))
        *limits |= CHAIN_VOLTAGE_RANGE;
    return voltage;
}

double chain_inverse(const struct chain *chain, struct chain_state *state, double displacement,
                     const struct chain_surroundings *around, unsigned *limits)
{
    const double aim = within_reach(chain, displacement);

    *limits = aim != displacement ? CHAIN_REFERENCE_RANGE : 0u;
    return chain->effects ? inverse_with_effects(chain, state, aim, around, limits)
                          : inverse_of_core(chain, state, aim, limits);
}

double chain_hold(const struct chain *chain, const struct chain_state *state)
{
    const double x = it2_solve(&chain->core, state->core.y, state->core.y);

    return chain->effects & CHAIN_PLAY ? play_solve(&chain->play, &state->play, x) : x;
}

double chain_equilibrium(const struct chain *chain, const struct chain_state *state)
{
    double x = chain_hold(chain, state);

    if (!isfinite(x)) /* nothing holds it there */
        return x;
    if (chain->effects & CHAIN_SATURATION)
        x = saturation_inverse(&chain->saturation, x);
    return within_voltages(chain, x);
}
