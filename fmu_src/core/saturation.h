/* Saturation of the amplifier: y_k = x_k within saturation.minimum..saturation.maximum.
 *
 * It loses information: the inverse gives the nearest voltage within the limits. No state. */
#ifndef IT2HYS_SATURATION_H
#define IT2HYS_SATURATION_H

#include "stage.h"

typedef struct saturation_parameters {
    real minimum; /* V; both 0: no limits */
    real maximum;
} saturation_parameters;

struct saturation {
    real minimum;
    real maximum;
};

HIDDEN_BEGIN
extern const struct stage saturation_stage;
extern const struct stage_analysis saturation_analysis;
HIDDEN_END

#endif
