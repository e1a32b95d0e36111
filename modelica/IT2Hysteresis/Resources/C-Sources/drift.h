/* Drift: y_k = x_k + drift.temperatureCoefficient (T_k - 293.15 K) + drift.rate t_k.
 *
 * t_k is the tick's own time. No state. Whoever knows the rate only after the fact leaves it out of
 * the inverse's set. */
#ifndef IT2HYS_DRIFT_H
#define IT2HYS_DRIFT_H

#include "effect.h"

#define DRIFT_REFERENCE_TEMPERATURE 293.15 /* K */

struct drift_parameters {
    double temperatureCoefficient; /* m/K */
    double rate;                   /* m/s */
};

HIDDEN_BEGIN

bool drift_is_on(const struct drift_parameters *parameters);
double drift_step(const struct drift_parameters *stage, double x, double temperature, double time);
double drift_inverse(const struct drift_parameters *stage, double y, double temperature, double time);
double drift_step_tangent(const struct drift_parameters *stage, double d_x, double d_temperature);
double drift_inverse_tangent(const struct drift_parameters *stage, double d_y, double d_temperature);

HIDDEN_END

#endif
