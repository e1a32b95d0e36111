/* Mechanical resonance, exact poles and at most one zero:
 * y_k = a1 y_{k-1} + a2 y_{k-2} + (1 - a1 - a2) (x_k - z x_{k-1}) / (1 - z).
 *
 * resonance.frequency is the undamped one. z is resonance.samplingZero, which a sampled resonance has where
 * its input runs straight between samples: -0.27, beside 0.79 of a tick of delay. Where it is held, half a
 * tick of delay does. Above -1 the inverse is stable; with z = 0 it has no memory. Linear.
 *
 * The output is y resonance.samplingDelay ago, straight between ticks; the inverse does not make up for that.
 * The chain's delay cannot stand for it: that delays what drives the core, which is not linear. */
#ifndef IT2HYS_RESONANCE_H
#define IT2HYS_RESONANCE_H

#include "stage.h"

typedef struct resonance_parameters {
    real frequency; /* Hz; 0: none */
    real damping;   /* of critical */
    real samplingZero;
    real samplingDelay; /* s, up to RESONANCE_MAX_TICKS */
} resonance_parameters;

/* Ticks of delay that the state can give. */
#define RESONANCE_MAX_TICKS 2

struct resonance {
    real a1;
    real a2;
    real b0;      /* (1 - a1 - a2) / (1 - z) */
    real b1;      /* -z b0 */
    real per_b0;  /* 1 / b0, without derivatives: an inverse waits for a division */
    real ticks;   /* of delay */
    real latency; /* the same in s */
};

struct resonance_state {
    real y1; /* y_{k-1} */
    real y2; /* y_{k-2} */
    real x1; /* x_{k-1} */
};

HIDDEN_BEGIN
extern const struct stage resonance_stage;
extern const struct stage_analysis resonance_analysis;
HIDDEN_END

#endif
