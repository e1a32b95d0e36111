/* Drift: y_k = x_k + drift.temperatureCoefficient (T_k - 293.15 K) + drift.rate t_k.
 *
 * t_k is the tick's own time. No state. Whoever knows the rate only after the fact leaves it out of
 * the inverse's set. */
#ifndef IT2HYS_DRIFT_H
#define IT2HYS_DRIFT_H

#include "stage.h"

#define DRIFT_REFERENCE_TEMPERATURE REAL(293.15) /* K */

typedef struct drift_parameters {
    real temperatureCoefficient; /* m/K */
    real rate;                   /* m/s */
} drift_parameters;

struct drift {
    real temperatureCoefficient;
    real rate;
};

HIDDEN_BEGIN
extern const struct stage drift_stage;
extern const struct stage_analysis drift_analysis;
HIDDEN_END

#endif
