/* The plant as a chain of invertible stages, walked forwards by the plant and backwards by the inverse.
 *
 *     voltage -> [delay] -> [slew] -> [saturation] -> [lag] -> [play] -> IT2 core
 *             -> [load] -> [creep] -> [resonance] -> [drift] -> [nonlinearity] -> displacement
 *             -> [hum] -> measured
 *
 * Stages in brackets are effects (stage.h); stages.h lists them. Those that are off are passed by: the chain
 * without effects is the IT2 core bit for bit. Constants are set once by chain_prepare; the state is a small
 * value that can be copied. Nothing is allocated and nothing is global.
 *
 * A displacement is what the sensor reads, in the core too. What scales with the stroke (creep,
 * nonlinearity) acts on what of it lies above displacementZero.
 *
 * Some stages lose information, and the inverse keeps to the displacements and the voltages that the
 * parameters hold for: beyond them the core is extrapolated. Where that cuts off what a reference asks for,
 * the inverse gives the nearest. Without effects it goes on from what the plant reaches. With effects, what
 * remembers for long is kept on what the plant reaches: the amplifier's voltage, the play operators and
 * creep. The inverses of core, lag and resonance remember one or two ticks, and of those what was aimed at:
 * the plant comes back to it by its own contraction. (To take the plant back in one tick from what it
 * reached would make a limit cycle of lag, core and slew limit.) So nothing winds up. Until the plant is
 * back, it is followed in `reached`, and the inverse says so. */
#ifndef IT2HYS_CHAIN_H
#define IT2HYS_CHAIN_H

#include <string.h>

#include "it2_table.h"
#include "stages.h"

/* Names are those of the variable table (python/it2hys/model/variables.toml). */
struct chain_parameters {
    real sampleTime;
    real initialDisplacement;
    real initialDemagnetisation;
    real initialExcursion;
    real initialCreep;
    real initialCreepAge;
    real voltageMin;
    real voltageMax;
    real displacementMin;
    real displacementMax;
    real displacementZero;
    int ruleCount;
    int playCount;
    int creepCount;
    struct it2_rule rule[IT2_MAX_RULES];
#define CHAIN_MEMBER(name, NAME, side) name##_parameters name;
    CHAIN_EVERY_STAGE(CHAIN_MEMBER)
};

/* clang-format off */
enum chain_stage {
#define CHAIN_INDEX(name, NAME, side) CHAIN_STAGE_##NAME,
    CHAIN_EVERY_STAGE(CHAIN_INDEX)
    CHAIN_STAGE_COUNT
};

enum chain_effect {
#define CHAIN_BIT(name, NAME, side) CHAIN_##NAME = 1 << CHAIN_STAGE_##NAME,
    CHAIN_EVERY_STAGE(CHAIN_BIT)
};
/* clang-format on */

struct chain_place;

struct chain {
    unsigned effects; /* that are on, between voltage and displacement (bits) */
    unsigned reading; /* that are on, between displacement and measured */
    const struct chain_place *active[CHAIN_STAGE_COUNT]; /* stages that are on, in their order */
    int before, behind, all;                             /* where in `active` those of each side end */
    /* of them, those that the inverse goes back over, in the same order: that solve, and that limit */
    const struct chain_place *solved[CHAIN_STAGE_COUNT], *limiting[CHAIN_STAGE_COUNT];
    int solved_before, solved_all, limiting_all;
    unsigned char remembering[CHAIN_STAGE_COUNT]; /* numbers in `solved` of those with a LONG memory */
    int remembering_all;
    bool followed[CHAIN_STAGE_COUNT]; /* of `limiting`: what it lets through is where the plant goes */
    struct it2 core;
    struct it2_range displacement; /* of the set */
    struct it2_range reference;    /* that a reference is kept to: wider where a stage behind the core rings */
    struct it2_range voltage;      /* that the inverse keeps to */
    real latency;                  /* of all stages, s */
    /* bytes of struct chain_state, from its beginning, that each way needs */
    size_t walked, retraced;
#define CHAIN_CONSTANTS(name, NAME, side) struct name name;
    CHAIN_EVERY_STAGE(CHAIN_CONSTANTS)
};

#define CHAIN_STATE(name, NAME, side) struct name##_state name;

/* What the plant reached, in the inverse, whose other states are what it aimed at. Only for a time after
 * something was cut off are they different. */
struct chain_reached {
    struct it2_state core;
    CHAIN_STAGES(CHAIN_SKIP, CHAIN_STATE, CHAIN_SKIP, CHAIN_SKIP, CHAIN_SKIP)
};

/* Of type real only. The core's comes first: without effects it is the only one in use. What is long is last. The
 * beginning, to `reached`, is what the inverse aimed at, in the same order. */
struct chain_state {
    struct it2_state core;
    CHAIN_STAGES(CHAIN_SKIP, CHAIN_STATE, CHAIN_SKIP, CHAIN_SKIP, CHAIN_SKIP)
    struct chain_reached reached;
    CHAIN_STAGES(CHAIN_SKIP, CHAIN_SKIP, CHAIN_STATE, CHAIN_SKIP, CHAIN_SKIP)
    CHAIN_STAGES(CHAIN_SKIP, CHAIN_SKIP, CHAIN_SKIP, CHAIN_STATE, CHAIN_SKIP)
    CHAIN_STAGES(CHAIN_SKIP, CHAIN_SKIP, CHAIN_SKIP, CHAIN_SKIP, CHAIN_STATE)
};

enum chain_memory { CHAIN_NONE, CHAIN_AIMED, CHAIN_SHORT, CHAIN_LONG, CHAIN_LONGEST };
enum chain_side { CHAIN_BEFORE, CHAIN_BEHIND, CHAIN_READING };

/* Where a stage is. */
struct chain_place {
    const struct stage *stage;
    enum chain_side side;
    enum chain_memory memory;
    size_t constants; /* in struct chain */
    size_t constants_size;
    size_t state;   /* in struct chain_state */
    size_t reached; /* the same for what the plant reached, where that is kept beside */
    size_t state_size;
};

/* Why the plant does not get to where it should. */
enum chain_limit {
    CHAIN_REFERENCE_RANGE = 1, /* displacementMin..displacementMax */
    CHAIN_AMPLIFIER = 2,       /* a stage that limits */
    CHAIN_VOLTAGE_RANGE = 4,   /* voltageMin..voltageMax */
    CHAIN_RETURNING = 8        /* it is not yet back from where one of these left it */
};

/* What acts on the chain beside its input. */
struct chain_surroundings {
    real force;
    real temperature;
    real time; /* of the tick */
};

/* A state and what the last step made of it, or their derivatives along one direction. */
struct chain_point {
    struct chain_state state;
    real output;
};

/* Is a value outside a range by more than rounding? An inverse that aims at an end takes the plant there but
 * for that. */
static inline bool chain_outside(real value, real minimum, real maximum)
{
    if (value >= minimum && value <= maximum)
        return false;
    const real slack = REAL(1e-9) * (maximum - minimum);
    return !(value >= minimum - slack && value <= maximum + slack);
}

/* Copies a few numbers, one by one: a processor that reads two at a time what was just written one by one
 * waits until it is in memory. Compilers make one copy of it only where the two cannot overlap. */
static inline void copy_words(void *to, const void *from, size_t size)
{
    for (size_t i = 0; i < size; i += sizeof(real))
        memcpy((char *)to + i, (const char *)from + i, sizeof(real));
}

HIDDEN_BEGIN

extern const struct chain_place CHAIN_PLACES[CHAIN_STAGE_COUNT]; /* by enum chain_stage */

/* Of the stages that are on: where they are, their constants and their states. */
static inline const struct chain_place *chain_active(const struct chain *chain, int i)
{
    return chain->active[i];
}

static inline const void *chain_constants_of(const struct chain *chain, const struct chain_place *place)
{
    return (const char *)chain + place->constants;
}

static inline void *chain_state_of(struct chain_state *state, const struct chain_place *place)
{
    return (char *)state + place->state;
}

/* The input of a stage at rest at the output y, and its state. */
static inline real chain_rest_of(const struct chain_place *place, const void *constants, void *state, real y,
                                 const struct chain_parameters *parameters)
{
    real *number = state;

    if (place->stage->rest)
        return place->stage->rest(constants, state, y, parameters);
    for (size_t i = 0; i < place->state_size / sizeof y; i++)
        number[i] = y;
    return y;
}

bool chain_check(const struct chain_parameters *parameters, char *message, size_t size);
void chain_prepare(struct chain *chain, const struct chain_parameters *parameters);

/* Afterwards: where all effects that are on are idle, steps and inverse are those without effects, bit for bit.
 * Not where derivatives by their parameters follow the steps. */
void chain_pass_by_idle(struct chain *chain, const struct chain_parameters *parameters);

/* At rest at initialDisplacement, without force, at drift's reference temperature, time 0: for long if
 * initialCreep is 0, after the play operators' history of initialDemagnetisation and initialExcursion. */
void chain_reset(const struct chain *chain, struct chain_state *state,
                 const struct chain_parameters *parameters);

/* Without effects, one branch is all that the chain adds to the core. */
real chain_step_effects(const struct chain *chain, struct chain_state *state, real voltage,
                        const struct chain_surroundings *around);
static inline real chain_step(const struct chain *chain, struct chain_state *state, real voltage,
                              const struct chain_surroundings *around)
{
    return chain->effects ? chain_step_effects(chain, state, voltage, around)
                          : it2_step(&chain->core, &state->core, voltage);
}

/* The same for a stage, at which nothing is known of what drives the core. */
static inline struct stage_surroundings chain_around(const struct chain_surroundings *around)
{
    return (struct stage_surroundings){ around->force, around->temperature, around->time, 0 };
}

/* Walks the active stages from number `first` to before `end`. */
real chain_walk(const struct chain *chain, int first, int end, struct chain_state *state, real x,
                const struct stage_surroundings *around);

/* The displacement with what is picked up on the way to the recorder. */
real chain_measure_effects(const struct chain *chain, real displacement, real time);
static inline real chain_measure(const struct chain *chain, real displacement, real time)
{
    return chain->reading ? chain_measure_effects(chain, displacement, time) : displacement;
}

/* Voltage that takes the plant to `displacement`. Where it does not get there, `*limits` says why (enum
 * chain_limit, or-ed; otherwise 0), and the voltage is the nearest that can be given. */
real chain_inverse(const struct chain *chain, struct chain_state *state, real displacement,
                   const struct chain_surroundings *around, unsigned *limits);

/* Directional derivatives of chain_step and chain_inverse at `state`, before either advances it:
 * from derivatives of state, input and surroundings to those of the next state and the output. */
struct chain_point chain_step_tangent(const struct chain *chain, const struct chain_state *state, real voltage,
                                      const struct chain_surroundings *around, struct chain_state d_state,
                                      real d_voltage, const struct chain_surroundings *d_around);
struct chain_point chain_inverse_tangent(const struct chain *chain, const struct chain_state *state,
                                         real displacement, const struct chain_surroundings *around,
                                         struct chain_state d_state, real d_displacement,
                                         const struct chain_surroundings *d_around);

/* Is the plant elsewhere than where the inverse aimed at? */
bool chain_is_astray(const struct chain_state *state);

/* Voltage that holds the plant where it is, and the nearest to it that the inverse may give; not finite where
 * none holds it. */
real chain_hold(const struct chain *chain, const struct chain_state *state);
real chain_equilibrium(const struct chain *chain, const struct chain_state *state);

/* Derivative of chain_equilibrium right after chain_reset, in the direction of `d_parameters`. */
real chain_equilibrium_tangent(const struct chain *chain, const struct chain_state *state,
                               const struct chain_parameters *parameters,
                               const struct chain_parameters *d_parameters);

/* By enum chain_stage. */
extern const struct stage_analysis *const CHAIN_ANALYSES[CHAIN_STAGE_COUNT];

static inline const struct stage_analysis *chain_analysis(const struct chain *chain, int i)
{
    return CHAIN_ANALYSES[chain->active[i] - CHAIN_PLACES];
}

/* Derivatives of the constants of all active stages, by the stages' tangents. */
void chain_prepare_tangent(const struct chain *chain, struct chain *d,
                           const struct chain_parameters *parameters,
                           const struct chain_parameters *d_parameters);

/* Derivative of the input at rest of the active stages from number `first` to before `end`, whose output there
 * is y, and of their states at rest. */
real chain_rest_tangent(const struct chain *chain, int first, int end, const struct chain *d_chain, real y,
                        const struct chain_parameters *parameters, struct chain_state *d, real d_y,
                        const struct chain_parameters *d_parameters);

HIDDEN_END

#endif
