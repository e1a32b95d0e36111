/* Delay of the voltage: y_k = u at the time t_k - delay.time, straight between ticks.
 *
 * A whole number of ticks is exact. The inverse cannot look ahead, so it has no part of this stage:
 * it drives the chain behind the delay, and the plant follows the reference that much later. Where
 * the reference is known ahead, a master hands it over delay.time early (with the force and the
 * temperature of that later time), and the plant follows it on time. */
#ifndef IT2HYS_DELAY_H
#define IT2HYS_DELAY_H

#include "stage.h"

#define DELAY_MAX_TICKS 64

typedef struct delay_parameters {
    real time;
} delay_parameters;

struct delay {
    int ticks;     /* whole ones */
    real fraction; /* of a tick beyond them */
    real time;
};

/* A ring of as many voltages as the delay needs: u_{k-1} is at number `newest`, u_{k-2} at the next, ... */
struct delay_state {
    real newest;
    real u[DELAY_MAX_TICKS];
};

HIDDEN_BEGIN
extern const struct stage delay_stage;
extern const struct stage_analysis delay_analysis;
HIDDEN_END

#endif
