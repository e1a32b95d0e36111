/* A stage that only tests/unit/test_stage_list.py puts into the list, behind the core:
 * y_k = x_k + tilt.gain (x_k - x_{k-1}). */
#ifndef IT2HYS_TILT_H
#define IT2HYS_TILT_H
#include "stage.h"
typedef struct tilt_parameters {
    double gain;
} tilt_parameters;
struct tilt {
    double gain;
};
struct tilt_state {
    double x;
};
extern const struct stage tilt_stage;
extern const struct stage_analysis tilt_analysis;
#endif
