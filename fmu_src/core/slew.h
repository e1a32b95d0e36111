/* Slew limit of the amplifier: |y_k - y_{k-1}| <= slew.rate Ts.
 *
 * It loses information: the inverse gives the nearest voltage that it lets through unchanged. */
#ifndef IT2HYS_SLEW_H
#define IT2HYS_SLEW_H

#include "stage.h"

typedef struct slew_parameters {
    real rate; /* V/s; 0: no limit */
} slew_parameters;

struct slew {
    real step; /* largest change from tick to tick */
};

struct slew_state {
    real y; /* y_{k-1} */
};

HIDDEN_BEGIN
extern const struct stage slew_stage;
extern const struct stage_analysis slew_analysis;
HIDDEN_END

#endif
