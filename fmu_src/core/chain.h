/* The plant as a chain of invertible stages, walked forwards by the plant and backwards by the inverse.
 *
 *     voltage -> IT2 core -> displacement
 *
 * Every stage has the same operations (see it2.h): reset, step, inverse and the derivative of its
 * output with respect to its input. Constants are set once by chain_prepare; the state is a small
 * value that can be copied. Nothing is allocated and nothing is global. */
#ifndef IT2HYS_CHAIN_H
#define IT2HYS_CHAIN_H

#include "it2.h"

/* Names are those of the variable table (python/it2hys/variables.toml). */
struct chain_parameters {
    double sampleTime;
    double initialDisplacement;
    double voltageMin;
    double voltageMax;
    double displacementMin;
    double displacementMax;
    int ruleCount;
    struct it2_rule rule[IT2_MAX_RULES];
};

struct chain {
    struct it2 core;
    struct it2_range displacement; /* where the chain is invertible */
};

struct chain_state {
    struct it2_state core;
};

/* A state and what the last step made of it, or their derivatives along one direction. */
struct chain_point {
    struct chain_state state;
    double output;
};

HIDDEN_BEGIN

bool chain_check(const struct chain_parameters *parameters, char *message, size_t size);
void chain_prepare(struct chain *chain, const struct chain_parameters *parameters);
void chain_reset(struct chain_state *state, const struct chain_parameters *parameters);

double chain_step(const struct chain *chain, struct chain_state *state, double voltage);

/* Voltage that takes the plant to `displacement`; out of reach, the nearest within reach is aimed at
 * and `*saturated` is set. The state follows what is aimed at, so that it does not wind up. */
double chain_inverse(const struct chain *chain, struct chain_state *state, double displacement,
                     bool *saturated);

/* Directional derivatives of chain_step and chain_inverse at `state`, before either advances it:
 * from derivatives of state and input to those of the next state and the output. */
struct chain_point chain_step_tangent(const struct chain *chain, const struct chain_state *state,
                                      double voltage, struct chain_state d_state, double d_voltage);
struct chain_point chain_inverse_tangent(const struct chain *chain, const struct chain_state *state,
                                         double displacement, struct chain_state d_state,
                                         double d_displacement);

/* Voltage that holds the plant where it is. */
double chain_equilibrium(const struct chain *chain, const struct chain_state *state);

/* Derivative of chain_equilibrium in the direction of `d_parameters`. */
double chain_equilibrium_tangent(const struct chain *chain, const struct chain_state *state,
                                 const struct chain_parameters *d_parameters);

HIDDEN_END

#endif
