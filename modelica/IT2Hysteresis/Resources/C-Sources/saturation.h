/* Saturation of the amplifier: y_k = x_k within saturation.minimum..saturation.maximum.
 *
 * It loses information: the inverse gives the nearest voltage within the limits. No state. */
#ifndef IT2HYS_SATURATION_H
#define IT2HYS_SATURATION_H

#include "effect.h"

struct saturation_parameters {
    double minimum; /* V; both 0: no limits */
    double maximum;
};

HIDDEN_BEGIN

bool saturation_check(const struct saturation_parameters *parameters, char *message, size_t size);
bool saturation_is_on(const struct saturation_parameters *parameters);
double saturation_step(const struct saturation_parameters *stage, double x);
double saturation_step_tangent(const struct saturation_parameters *stage, double x, double d_x);
double saturation_inverse(const struct saturation_parameters *stage, double y);

HIDDEN_END

#endif
