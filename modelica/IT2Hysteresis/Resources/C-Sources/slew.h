/* Slew limit of the amplifier: |y_k - y_{k-1}| <= slew.rate Ts.
 *
 * It loses information: the inverse gives the nearest voltage that can be reached. */
#ifndef IT2HYS_SLEW_H
#define IT2HYS_SLEW_H

#include "effect.h"

struct slew_parameters {
    double rate; /* V/s; 0: no limit */
};

struct slew {
    double step; /* largest change from tick to tick */
};

struct slew_state {
    double y; /* y_{k-1} */
};

HIDDEN_BEGIN

bool slew_check(const struct slew_parameters *parameters, char *message, size_t size);
void slew_prepare(struct slew *stage, const struct slew_parameters *parameters, double sample_time);
void slew_reset(struct slew_state *state, double y);
double slew_step(const struct slew *stage, struct slew_state *state, double x);
double slew_step_tangent(const struct slew *stage, const struct slew_state *state, double x,
                         struct slew_state *d_state, double d_x);

/* The voltage nearest to y that the stage lets through unchanged; the state follows it. Its tangent
 * is slew_step_tangent. */
double slew_inverse(const struct slew *stage, struct slew_state *state, double y);

HIDDEN_END

#endif
