/* Mechanical resonance, exact poles and no zeros: y_k = a1 y_{k-1} + a2 y_{k-2} + (1 - a1 - a2) x_k.
 *
 * resonance.frequency is the undamped one. With no zeros the inverse is a stable three-tap expression.
 * Linear. */
#ifndef IT2HYS_RESONANCE_H
#define IT2HYS_RESONANCE_H

#include "stage.h"

typedef struct resonance_parameters {
    real frequency; /* Hz; 0: none */
    real damping;   /* of critical */
} resonance_parameters;

struct resonance {
    real a1;
    real a2;
    real b;     /* 1 - a1 - a2 */
    real per_b; /* 1 / b, without derivatives: an inverse waits for a division */
};

struct resonance_state {
    real y1; /* y_{k-1} */
    real y2; /* y_{k-2} */
};

HIDDEN_BEGIN
extern const struct stage resonance_stage;
extern const struct stage_analysis resonance_analysis;
HIDDEN_END

#endif
