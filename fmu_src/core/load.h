/* Elastic load: y_k = x_k - load.compliance F_k, the force F compressive positive. Linear in x and F;
 * no state. */
#ifndef IT2HYS_LOAD_H
#define IT2HYS_LOAD_H

#include "stage.h"

typedef struct load_parameters {
    real compliance; /* m/N; 0: rigid */
} load_parameters;

struct load {
    real compliance;
};

HIDDEN_BEGIN
extern const struct stage load_stage;
extern const struct stage_analysis load_analysis;
HIDDEN_END

#endif
