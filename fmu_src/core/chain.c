#include "chain.h"

#include <math.h>

/* V: the amplifier's limits are said to cut off what they change by more than rounding. */
#define NEGLIGIBLE 1e-9

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
    chain->effects = effects & ~(unsigned)CHAIN_READING;
    chain->reading = effects & CHAIN_READING;
    delay_prepare(&chain->delay, &p->delay, p->sampleTime);
    slew_prepare(&chain->slew, &p->slew, p->sampleTime);
    chain->saturation = p->saturation;
    play_prepare(&chain->play, p->play, p->playCount);
    chain->load = p->load;
    creep_prepare(&chain->creep, p->creep, p->creepCount, p->sampleTime);
    chain->drift = p->drift;
    nonlinearity_prepare(&chain->nonlinearity, &p->nonlinearity);
    chain->hum = p->hum;
    if (effects & CHAIN_LAG)
        lag_prepare(&chain->lag, &p->lag, p->sampleTime);
    if (effects & CHAIN_RESONANCE)
        resonance_prepare(&chain->resonance, &p->resonance, p->sampleTime);
}

void chain_reset(const struct chain *chain, struct chain_state *state,
                 const struct chain_parameters *parameters)
{
    double y = parameters->initialDisplacement;

    *state = (struct chain_state){ 0 };
    if (chain->effects & CHAIN_RESONANCE)
        resonance_reset(&state->resonance, y);
    if (chain->effects & CHAIN_CREEP)
        y = creep_reset(&chain->creep, &state->creep, y, parameters->initialCreep);
    it2_reset(&state->core, y);
    if (!chain->effects)
        return;
    const double x = play_reset(&chain->play, &state->play, it2_solve(&chain->core, y, y),
                                chain_history(parameters));
    lag_reset(&state->lag, x);
    it2_reset(&state->reached.core, y);
    lag_reset(&state->reached.lag, x);
    slew_reset(&state->slew, x);
    delay_reset(&state->delay, x);
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

double chain_respond(const struct chain *chain, struct chain_state *state, double y,
                     const struct chain_surroundings *around)
{
    if (chain->effects & CHAIN_LOAD)
        y = load_step(&chain->load, y, around->force);
    if (chain->effects & CHAIN_CREEP)
        y = creep_step(&chain->creep, &state->creep, y);
    if (chain->effects & CHAIN_RESONANCE)
        y = resonance_step(&chain->resonance, &state->resonance, y);
    if (chain->effects & CHAIN_DRIFT)
        y = drift_step(&chain->drift, y, around->temperature, around->time);
    return y;
}

double chain_step_effects(const struct chain *chain, struct chain_state *state, double voltage,
                          const struct chain_surroundings *around)
{
    const double x = chain_drive(chain, state, voltage);
    return chain_respond(chain, state, it2_step(&chain->core, &state->core, x), around);
}

double chain_measure_effects(const struct chain *chain, double displacement, double time)
{
    double reading = displacement;

    if (chain->reading & CHAIN_NONLINEARITY)
        reading = nonlinearity_step(&chain->nonlinearity, reading);
    if (chain->reading & CHAIN_HUM)
        reading = hum_step(&chain->hum, reading, time);
    return reading;
}

/* --- backwards --------------------------------------------------------------------------------- */

/* What the core has to reach. Drift is that of the time when the voltage arrives. */
static double core_target(const struct chain *chain, struct chain_state *state, double y,
                          const struct chain_surroundings *around)
{
    if (chain->effects & CHAIN_DRIFT)
        y = drift_inverse(&chain->drift, y, around->temperature, around->time + chain->delay.time);
    if (chain->effects & CHAIN_RESONANCE)
        y = resonance_inverse(&chain->resonance, &state->resonance, y);
    if (chain->effects & CHAIN_CREEP)
        y = creep_solve(&chain->creep, &state->creep, y);
    if (chain->effects & CHAIN_LOAD)
        y = load_inverse(&chain->load, y, around->force);
    return y;
}

/* The nearest voltage that the amplifier can give. */
static double within_limits(const struct chain *chain, struct chain_state *state, double x)
{
    if (chain->effects & CHAIN_SATURATION)
        x = saturation_inverse(&chain->saturation, x);
    if (chain->effects & CHAIN_SLEW)
        x = slew_inverse(&chain->slew, &state->slew, x);
    return x;
}

static double within_reach(const struct chain *chain, double displacement)
{
    return fmin(fmax(displacement, chain->core.lower.y), chain->core.upper.y);
}

/* The plant's way with the voltage given: advances what remembers for long. `x` and `aim` are what is
 * aimed at before and behind the core. */
static void follow_plant(const struct chain *chain, struct chain_state *state, double voltage, double x,
                         double aim, const struct chain_surroundings *around)
{
    const bool limited = chain->effects & (CHAIN_SLEW | CHAIN_SATURATION);

    if (chain->effects & CHAIN_SATURATION) /* it may rest beyond its limits */
        voltage = saturation_step(&chain->saturation, voltage);
    if (limited)
        x = chain->effects & CHAIN_LAG ? lag_step(&chain->lag, &state->reached.lag, voltage) : voltage;
    if (chain->effects & CHAIN_PLAY)
        x = play_step(&chain->play, &state->play, x);
    if (limited)
        aim = it2_step(&chain->core, &state->reached.core, x);
    if (chain->effects & CHAIN_LOAD)
        aim = load_step(&chain->load, aim, around->force);
    if (chain->effects & CHAIN_CREEP)
        creep_step(&chain->creep, &state->creep, aim);
}

static double inverse_with_effects(const struct chain *chain, struct chain_state *state,
                                   double displacement, const struct chain_surroundings *around,
                                   unsigned *limits)
{
    const double target = core_target(chain, state, displacement, around);
    const double aim = within_reach(chain, target);
    double x = it2_inverse(&chain->core, &state->core, aim);

    if (chain->effects & CHAIN_PLAY)
        x = play_solve(&chain->play, &state->play, x);
    const double wanted = chain->effects & CHAIN_LAG ? lag_inverse(&chain->lag, &state->lag, x) : x;
    const double voltage = within_limits(chain, state, wanted);
    *limits = (aim != target ? CHAIN_CORE_RANGE : 0u) |
              (fabs(voltage - wanted) <= NEGLIGIBLE ? 0u : CHAIN_AMPLIFIER);
    follow_plant(chain, state, voltage, x, aim, around);
    return voltage;
}

double chain_inverse(const struct chain *chain, struct chain_state *state, double displacement,
                     const struct chain_surroundings *around, unsigned *limits)
{
    if (chain->effects)
        return inverse_with_effects(chain, state, displacement, around, limits);
    const double aim = within_reach(chain, displacement);
    *limits = aim != displacement ? CHAIN_CORE_RANGE : 0u;
    return it2_inverse(&chain->core, &state->core, aim);
}

double chain_equilibrium(const struct chain *chain, const struct chain_state *state)
{
    double x = it2_solve(&chain->core, state->core.y, state->core.y);

    if (chain->effects & CHAIN_PLAY)
        x = play_solve(&chain->play, &state->play, x);
    if (chain->effects & CHAIN_SATURATION)
        x = saturation_inverse(&chain->saturation, x);
    return x;
}
