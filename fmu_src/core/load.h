/* Elastic load: y_k = x_k - load.compliance F_k, the force F compressive positive. Linear in x and F;
 * no state. */
#ifndef IT2HYS_LOAD_H
#define IT2HYS_LOAD_H

#include "effect.h"

struct load_parameters {
    double compliance; /* m/N; 0: rigid */
};

HIDDEN_BEGIN

bool load_check(const struct load_parameters *parameters, char *message, size_t size);
double load_step(const struct load_parameters *stage, double x, double force);
double load_inverse(const struct load_parameters *stage, double y, double force);

HIDDEN_END

#endif
