/* The plant as a chain of invertible stages, walked forwards by the plant and backwards by the inverse.
 *
 *     voltage -> [delay] -> [slew] -> [saturation] -> [lag] -> [play] -> IT2 core
 *             -> [load] -> [creep] -> [resonance] -> [drift] -> [nonlinearity] -> displacement
 *             -> [hum] -> measured
 *
 * Stages in brackets are effects (effect.h). Those that are off are passed by: the chain without
 * effects is the IT2 core bit for bit. Constants are set once by chain_prepare; the state is a small
 * value that can be copied. Nothing is allocated and nothing is global.
 *
 * A displacement is what the sensor reads, in the core too. What scales with the stroke (creep,
 * nonlinearity) acts on what of it lies above displacementZero.
 *
 * Delay, slew limit and saturation lose information, and the inverse keeps to the displacements and the
 * voltages that the parameters hold for: beyond them the core is extrapolated. Where that cuts off what a reference asks for, the inverse
 * gives the nearest. Without effects it goes on from what the plant reaches. With effects, what remembers
 * for long is kept on what the plant reaches: the amplifier's voltage, the play operators and creep. The
 * inverses of core, lag and resonance remember one or two ticks, and of those what was aimed at: the plant
 * comes back to it by its own contraction. (To take the plant back in one tick from what it reached would
 * make a limit cycle of lag, core and slew limit.) So nothing winds up. Until the plant is back, it is
 * followed in `reached`, and the inverse says so. */
#ifndef IT2HYS_CHAIN_H
#define IT2HYS_CHAIN_H

#include <string.h>

#include "creep.h"
#include "delay.h"
#include "drift.h"
#include "hum.h"
#include "it2.h"
#include "lag.h"
#include "load.h"
#include "nonlinearity.h"
#include "play.h"
#include "resonance.h"
#include "saturation.h"
#include "slew.h"

/* Names are those of the variable table (python/it2hys/variables.toml). */
struct chain_parameters {
    double sampleTime;
    double initialDisplacement;
    double initialRestOffset;
    double initialExcursion;
    double initialCreep;
    double voltageMin;
    double voltageMax;
    double displacementMin;
    double displacementMax;
    double displacementZero;
    int ruleCount;
    int playCount;
    int creepCount;
    struct it2_rule rule[IT2_MAX_RULES];
    struct play_element play[PLAY_MAX];
    struct creep_element creep[CREEP_MAX];
    struct delay_parameters delay;
    struct slew_parameters slew;
    struct saturation_parameters saturation;
    struct lag_parameters lag;
    struct load_parameters load;
    struct resonance_parameters resonance;
    struct drift_parameters drift;
    struct nonlinearity_parameters nonlinearity;
    struct hum_parameters hum;
};

enum chain_effect {
    CHAIN_DELAY = 1,
    CHAIN_SLEW = 2,
    CHAIN_SATURATION = 4,
    CHAIN_LAG = 8,
    CHAIN_PLAY = 16,
    CHAIN_LOAD = 32,
    CHAIN_CREEP = 64,
    CHAIN_RESONANCE = 128,
    CHAIN_DRIFT = 256,
    CHAIN_NONLINEARITY = 512,
    CHAIN_HUM = 1024,
    CHAIN_READING = CHAIN_HUM
};

struct chain {
    unsigned effects; /* that are on, between voltage and displacement (enum chain_effect, or-ed) */
    unsigned reading; /* that are on, between displacement and measured */
    struct it2 core;
    struct it2_range displacement;       /* that a reference is kept to */
    struct saturation_parameters voltage; /* that the inverse keeps to */
    double zero;                          /* displacementZero */
    struct delay delay;
    struct slew slew;
    struct saturation_parameters saturation;
    struct lag lag;
    struct play play;
    struct load_parameters load;
    struct creep creep;
    struct resonance resonance;
    struct drift_parameters drift;
    struct nonlinearity nonlinearity;
    struct hum_parameters hum;
};

/* What the plant reached, in the inverse, whose other states are what it aimed at. Only for a time after
 * something was cut off are they different. */
struct chain_reached {
    struct it2_state core;
    struct lag_state lag;
    struct resonance_state resonance;
};

/* Doubles only. The core's comes first: without effects it is the only one in use. What is long is last. */
struct chain_state {
    struct it2_state core;
    struct slew_state slew;
    struct lag_state lag;
    struct resonance_state resonance;
    struct chain_reached reached;
    struct play_state play;
    struct creep_state creep;
    struct delay_state delay;
};

/* What acts on the chain beside its input. */
struct chain_surroundings {
    double force;
    double temperature;
    double time; /* of the tick */
};

/* Why the plant does not get to where it should. */
enum chain_limit {
    CHAIN_REFERENCE_RANGE = 1, /* displacementMin..displacementMax */
    CHAIN_AMPLIFIER = 2,       /* slew limit or saturation */
    CHAIN_VOLTAGE_RANGE = 4,   /* voltageMin..voltageMax */
    CHAIN_RETURNING = 8        /* it is not yet back from where one of these left it */
};

/* A state and what the last step made of it, or their derivatives along one direction. */
struct chain_point {
    struct chain_state state;
    double output;
};

/* Is a value outside a range by more than rounding? An inverse that aims at an end takes the plant there but
 * for that. */
static inline bool chain_outside(double value, double minimum, double maximum)
{
    if (value >= minimum && value <= maximum)
        return false;
    const double slack = 1e-9 * (maximum - minimum);
    return !(value >= minimum - slack && value <= maximum + slack);
}

HIDDEN_BEGIN

static inline struct play_history chain_history(const struct chain_parameters *parameters)
{
    return (struct play_history){ parameters->initialRestOffset, parameters->initialExcursion };
}

bool chain_check(const struct chain_parameters *parameters, char *message, size_t size);
void chain_prepare(struct chain *chain, const struct chain_parameters *parameters);

/* At rest at initialDisplacement, without force, at drift's reference temperature, time 0: for long if
 * initialCreep is 0, after the play operators' history of initialRestOffset and initialExcursion. */
void chain_reset(const struct chain *chain, struct chain_state *state,
                 const struct chain_parameters *parameters);

/* The part of it behind the core; returns the core's output. */
double chain_reset_response(const struct chain *chain, struct chain_state *state,
                            const struct chain_parameters *parameters);

/* Bytes of the state, from its beginning, that are in use. */
static inline size_t chain_state_in_use(const struct chain *chain)
{
    return !chain->effects                  ? sizeof(struct it2_state)
           : chain->effects & CHAIN_DELAY ? sizeof(struct chain_state)
           : chain->effects & CHAIN_CREEP ? offsetof(struct chain_state, delay)
           : chain->effects & CHAIN_PLAY  ? offsetof(struct chain_state, creep)
                                          : offsetof(struct chain_state, play);
}

static inline void chain_copy(const struct chain *chain, struct chain_state *to,
                              const struct chain_state *from)
{
    memcpy(to, from, chain_state_in_use(chain));
}

/* Without effects, one branch is all that the chain adds to the core. */
double chain_step_effects(const struct chain *chain, struct chain_state *state, double voltage,
                          const struct chain_surroundings *around);
static inline double chain_step(const struct chain *chain, struct chain_state *state, double voltage,
                                const struct chain_surroundings *around)
{
    return chain->effects ? chain_step_effects(chain, state, voltage, around)
                          : it2_step(&chain->core, &state->core, voltage);
}

/* The parts of a step before and behind the core: voltage to core's input, core's output to
 * displacement. */
double chain_drive(const struct chain *chain, struct chain_state *state, double x);
double chain_respond(const struct chain *chain, struct chain_state *state, double y,
                     const struct chain_surroundings *around);

/* Takes *x to the core's input and advances `state`, and with it the derivatives `d` of the state by a
 * direction in which x changes by d_x. Returns the derivative of the core's input. */
double chain_drive_tangent(const struct chain *chain, struct chain_state *state, double *x,
                           struct chain_state *d, double d_x);

/* The two parts of chain_respond: the affine stages and the static curve. */
double chain_respond_affine(const struct chain *chain, struct chain_state *state, double y,
                            const struct chain_surroundings *around);
double chain_bend(const struct chain *chain, double y);
double chain_bend_tangent(const struct chain *chain, double y, double d_y);

/* The displacement with what is picked up on the way to the recorder. */
double chain_measure_effects(const struct chain *chain, double displacement, double time);
static inline double chain_measure(const struct chain *chain, double displacement, double time)
{
    return chain->reading ? chain_measure_effects(chain, displacement, time) : displacement;
}

/* Voltage that takes the plant to `displacement`. Where it does not get there, `*limits` says why (enum
 * chain_limit, or-ed; otherwise 0), and the voltage is the nearest that can be given. */
double chain_inverse(const struct chain *chain, struct chain_state *state, double displacement,
                     const struct chain_surroundings *around, unsigned *limits);

/* Directional derivatives of chain_step and chain_inverse at `state`, before either advances it:
 * from derivatives of state, input and surroundings to those of the next state and the output. */
struct chain_point chain_step_tangent(const struct chain *chain, const struct chain_state *state,
                                      double voltage, const struct chain_surroundings *around,
                                      struct chain_state d_state, double d_voltage,
                                      const struct chain_surroundings *d_around);
struct chain_point chain_inverse_tangent(const struct chain *chain, const struct chain_state *state,
                                         double displacement, const struct chain_surroundings *around,
                                         struct chain_state d_state, double d_displacement,
                                         const struct chain_surroundings *d_around);

/* Is the plant elsewhere than where the inverse aimed at? */
bool chain_is_astray(const struct chain_state *state);

/* Voltage that holds the plant where it is, and the nearest to it that the inverse may give; not finite where
 * none holds it. */
double chain_hold(const struct chain *chain, const struct chain_state *state);
double chain_equilibrium(const struct chain *chain, const struct chain_state *state);

/* Derivative of chain_equilibrium right after chain_reset, in the direction of `d_parameters`. */
double chain_equilibrium_tangent(const struct chain *chain, const struct chain_state *state,
                                 const struct chain_parameters *parameters,
                                 const struct chain_parameters *d_parameters);

HIDDEN_END

#endif
