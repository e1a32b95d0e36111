/* What all stages of the chain share. A stage is a scalar causal map with a state of its own; those of this
 * folder beside the core are effects, off by default, one file each. The list of them is in stages.h.
 *
 * A stage's file defines
 *     <stage>_parameters           a type with the names of the variable table
 *     struct <stage>               constants, which follow from the parameters
 *     struct <stage>_state         of type real, where it has one
 *     <stage>_stage                what runs in a tick
 *     <stage>_analysis             what only hosts need: words for a bad parameter, and exact derivatives
 * and the chain does the rest. Constants and states come as pointers to these structs; a stage without a
 * state leaves its pointer alone. */
#ifndef IT2HYS_STAGE_H
#define IT2HYS_STAGE_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "hidden.h"
#include "real.h"

#define TWO_PI REAL(6.283185307179586)

struct chain_parameters;

/* What acts on a stage beside its input. */
struct stage_surroundings {
    real force;
    real temperature;
    real time;    /* of the tick */
    real voltage; /* that drives the core; behind the core, next states may depend on it */
};

/* The same where another voltage drives the core. */
static inline struct stage_surroundings driven_by(const struct stage_surroundings *around, real voltage)
{
    return (struct stage_surroundings){ around->force, around->temperature, around->time, voltage };
}

struct stage {
    bool limits; /* it loses what is beyond: its inverse gives the nearest */
    bool (*is_on)(const struct chain_parameters *);

    /* It is on, and gives what it gets, whatever that is; NULL: it never does. */
    bool (*is_idle)(const struct chain_parameters *);
    void (*prepare)(void *constants, const struct chain_parameters *);

    /* At rest at the output y; returns the input. NULL: that is y, and so are all numbers of the state. Before
     * the core, with a memory that is not LONG, the constants say all: there may be no parameters. */
    real (*rest)(const void *constants, void *state, real y, const struct chain_parameters *);

    /* Input to output; advances the state. */
    real (*step)(const void *constants, void *state, real x, const struct stage_surroundings *);

    /* Output to input. A state of the memory AIMED or SHORT (stages.h) is advanced to what `step` would have
     * left, a long one stays. NULL: the stage has no part in the inverse. */
    real (*inverse)(const void *constants, void *state, real y, const struct stage_surroundings *);

    /* How many bytes of the state are in use, from its beginning. NULL: all. */
    size_t (*used)(const void *constants);

    /* How much later its output comes, in s, where the inverse does not make up for that; NULL: at once. */
    real (*latency)(const void *constants);
};

/* Derivatives along a direction; d_ is the derivative of what has the name without it. NULL: the output's is
 * the input's, there is no state, and no parameter or surrounding counts. */
struct stage_analysis {
    /* Are the parameters usable? If not, the message names the culprit. */
    bool (*check)(const struct chain_parameters *, char *message, size_t size);

    /* Of `prepare`; d_constants holds zeros. NULL: that is linear, without a constant or a sampleTime. */
    void (*prepare_tangent)(void *d_constants, const void *constants, const struct chain_parameters *,
                            const struct chain_parameters *d);

    /* Of `rest`, which has returned x and left the state; NULL where that is. */
    real (*rest_tangent)(const void *constants, const void *d_constants, const void *state, void *d_state,
                         real x, real d_y, const struct chain_parameters *, const struct chain_parameters *d);

    /* Of `step` by state, input and surroundings, along `count` directions at once: number i of the state has
     * its derivatives from d_state[i * count] on, d_around one for each; `row` goes from those of the input to
     * those of the output. */
    void (*tangent)(const void *constants, const void *state, real x, const struct stage_surroundings *around,
                    const struct stage_surroundings *d_around, int count, real *restrict d_state,
                    real *restrict row);

    /* Of `step` by the constants alone: returns that of the output, and adds to d_state[i * stride]. */
    real (*by_parameters)(const void *constants, const void *d_constants, const void *state, real x,
                          const struct stage_surroundings *, real *d_state, int stride);

    /* Of `inverse`, which has returned x, by state, output and surroundings. For a stage that limits it is
     * `tangent`. */
    real (*inverse_tangent)(const void *constants, const void *state, real x, void *d_state, real d_y,
                            const struct stage_surroundings *around, const struct stage_surroundings *d_around);
};

/* Directions that a tangent takes at a time, where it has to keep their inputs. */
enum { STAGE_CHUNK = 32 };

/* Writes why a parameter set cannot be used; returns false. */
static inline bool refuse(char *message, size_t size, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(message, size, format, arguments);
    va_end(arguments);
    return false;
}

/* A NaN stays one. */
static inline real clamp(real value, real low, real high)
{
    return value < low ? low : value > high ? high : value;
}

#endif
