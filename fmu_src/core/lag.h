/* First-order lag of the amplifier, exact pole and no zero: y_k = y_{k-1} + g (x_k - y_{k-1}) with
 * g = 1 - exp(-Ts / lag.timeConstant). Linear. */
#ifndef IT2HYS_LAG_H
#define IT2HYS_LAG_H

#include "stage.h"

typedef struct lag_parameters {
    real timeConstant; /* s; 0: none */
} lag_parameters;

struct lag {
    real gain;     /* g */
    real per_gain; /* 1 / g, without derivatives: an inverse waits for a division */
};

struct lag_state {
    real y; /* y_{k-1} */
};

HIDDEN_BEGIN
extern const struct stage lag_stage;
extern const struct stage_analysis lag_analysis;
HIDDEN_END

#endif
