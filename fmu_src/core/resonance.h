/* Mechanical resonance, exact poles and no zeros: y_k = a1 y_{k-1} + a2 y_{k-2} + (1 - a1 - a2) x_k.
 *
 * resonance.frequency is the undamped one. With no zeros the inverse is a stable three-tap expression.
 * Linear. */
#ifndef IT2HYS_RESONANCE_H
#define IT2HYS_RESONANCE_H

#include "effect.h"

struct resonance_parameters {
    double frequency; /* Hz; 0: none */
    double damping;   /* of critical */
};

struct resonance {
    double a1;
    double a2;
    double b; /* 1 - a1 - a2 */
};

struct resonance_state {
    double y1; /* y_{k-1} */
    double y2; /* y_{k-2} */
};

HIDDEN_BEGIN

bool resonance_check(const struct resonance_parameters *parameters, double sample_time, char *message,
                     size_t size);
void resonance_prepare(struct resonance *stage, const struct resonance_parameters *parameters,
                       double sample_time);
void resonance_reset(struct resonance_state *state, double y);
double resonance_step(const struct resonance *stage, struct resonance_state *state, double x);
double resonance_inverse(const struct resonance *stage, struct resonance_state *state, double y);

HIDDEN_END

#endif
