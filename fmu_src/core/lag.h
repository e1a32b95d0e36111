/* First-order lag of the amplifier, exact pole and no zero: y_k = y_{k-1} + g (x_k - y_{k-1}) with
 * g = 1 - exp(-Ts / lag.timeConstant). Linear. */
#ifndef IT2HYS_LAG_H
#define IT2HYS_LAG_H

#include "effect.h"

struct lag_parameters {
    double timeConstant; /* s; 0: none */
};

struct lag {
    double gain; /* g */
};

struct lag_state {
    double y; /* y_{k-1} */
};

HIDDEN_BEGIN

bool lag_check(const struct lag_parameters *parameters, double sample_time, char *message, size_t size);
void lag_prepare(struct lag *stage, const struct lag_parameters *parameters, double sample_time);
void lag_reset(struct lag_state *state, double y);
double lag_step(const struct lag *stage, struct lag_state *state, double x);
double lag_inverse(const struct lag *stage, struct lag_state *state, double y);

HIDDEN_END

#endif
