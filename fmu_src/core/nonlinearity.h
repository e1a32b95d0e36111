/* Static curve, the stack's or the sensor's: z maps minimum..maximum, counted from the sensor's zero, to
 * -1..1, and
 *     y = x + (1 - z^2) (quadratic + cubic z + quartic z^2 + quintic z^3 + sextic z^4),
 * x at both ends, and beyond them on with the slope that it has there. It rises with x, so that the inverse is
 * Newton's method between the ends. No state. */
#ifndef IT2HYS_NONLINEARITY_H
#define IT2HYS_NONLINEARITY_H

#include "stage.h"

typedef struct nonlinearity_parameters {
    real quadratic; /* m, as the others */
    real cubic;
    real quartic;
    real quintic;
    real sextic;
    real minimum; /* ends of the curve, from the sensor's zero */
    real maximum;
} nonlinearity_parameters;

struct nonlinearity {
    struct nonlinearity_parameters coefficient;
    real centre;
    real half_range;
    /* so that nothing is divided in a tick; without derivatives */
    real per_half_range;
    struct nonlinearity_parameters scaled; /* in half ranges */
    bool cubic;                            /* at most: the other terms are all 0 */
    int steps; /* of Newton's method that are enough anywhere; 0 where the curve bends too much to know */
};

HIDDEN_BEGIN
extern const struct stage nonlinearity_stage;
extern const struct stage_analysis nonlinearity_analysis;
HIDDEN_END

#endif
