/* Static curve between displacement and reading: z maps minimum..maximum to -1..1, and
 *     reading = y + (1 - z^2) (quadratic + cubic z + quartic z^2),
 * zero at both ends and beyond. It rises with y. No state.
 *
 * It acts on `measured` only, so that the inverse, which aims at the displacement, has no part of it. */
#ifndef IT2HYS_NONLINEARITY_H
#define IT2HYS_NONLINEARITY_H

#include "effect.h"

struct nonlinearity_parameters {
    double quadratic; /* m, as the others */
    double cubic;
    double quartic;
    double minimum; /* ends of the curve */
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
void nonlinearity_prepare(struct nonlinearity *stage, const struct nonlinearity_parameters *parameters);
double nonlinearity_step(const struct nonlinearity *stage, double y);
double nonlinearity_derivative(const struct nonlinearity *stage, double y);

HIDDEN_END

#endif
