/* Creep: y_k = x_k + sum_i c_i s_i,k with s_i,k = s_i,k-1 + g_i (x_k - s_i,k-1), g_i = 1 - exp(-Ts / tau_i).
 *
 * s_i at tick k includes x_k, so that a stage much faster than Ts is a plain gain. y is affine in x
 * with the slope 1 + sum_i c_i g_i. The inverse is stable where 1 + the sum of the negative gains is
 * positive. All of this is counted from the sensor's zero. */
#ifndef IT2HYS_CREEP_H
#define IT2HYS_CREEP_H

#include "stage.h"

enum { CREEP_MAX = 16 };

struct creep_element {
    double gain;         /* c_i: creep in the end, per displacement */
    double timeConstant; /* tau_i, s */
};

typedef struct creep_element creep_parameters[CREEP_MAX];

struct creep {
    int first; /* of derivatives: those before are 0 */
    int count;
    double zero;            /* the sensor's */
    double gain[CREEP_MAX]; /* c_i */
    double rate[CREEP_MAX]; /* g_i */
    double slope;           /* dy_k / dx_k */
};

struct creep_state {
    double s[CREEP_MAX]; /* s_i,k-1 */
};

HIDDEN_BEGIN
extern const struct stage creep_stage;
extern const struct stage_analysis creep_analysis;
HIDDEN_END

#endif
