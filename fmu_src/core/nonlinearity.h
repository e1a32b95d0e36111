/* Static curve, the stack's or the sensor's: z maps minimum..maximum, counted from the sensor's zero, to
 * -1..1, and
 *     y = x + (1 - z^2) (quadratic + cubic z + quartic z^2),
 * x at both ends and beyond. It rises with x, so that the inverse is Newton's method between the ends. No
 * state. */
#ifndef IT2HYS_NONLINEARITY_H
#define IT2HYS_NONLINEARITY_H

#include "effect.h"

struct nonlinearity_parameters {
    double quadratic; /* m, as the others */
    double cubic;
    double quartic;
    double minimum; /* ends of the curve, from the sensor's zero */
    double maximum;
};

struct nonlinearity {
    struct nonlinearity_parameters coefficient;
    double centre;
    double half_range;
};

HIDDEN_BEGIN

bool nonlinearity_is_on(const struct nonlinearity_parameters *parameters);
bool nonlinearity_check(const struct nonlinearity_parameters *parameters, char *message, size_t size);
void nonlinearity_prepare(struct nonlinearity *stage, const struct nonlinearity_parameters *parameters,
                          double zero);
double nonlinearity_step(const struct nonlinearity *stage, double x);
double nonlinearity_inverse(const struct nonlinearity *stage, double y);

/* dy / dx. */
double nonlinearity_derivative(const struct nonlinearity *stage, double x);

/* Derivative of nonlinearity_inverse where it returns x, in the direction of `d`, d_zero and d_y. */
double nonlinearity_inverse_tangent(const struct nonlinearity *stage, double x,
                                    const struct nonlinearity_parameters *d, double d_zero, double d_y);

HIDDEN_END

#endif
