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
    real gain;         /* c_i: creep in the end, per displacement */
    real timeConstant; /* tau_i, s */
};

typedef struct creep_element creep_parameters[CREEP_MAX];

struct creep {
    int first; /* of derivatives: those before are 0 */
    int count;
    real zero;            /* the sensor's */
    real gain[CREEP_MAX]; /* c_i */
    real rate[CREEP_MAX]; /* g_i */
    real slope;           /* dy_k / dx_k */
    real per_slope;       /* 1 / that, without derivatives: an inverse waits for a division */
};

struct creep_state {
    real s[CREEP_MAX]; /* s_i,k-1 */
};

HIDDEN_BEGIN
extern const struct stage creep_stage;
extern const struct stage_analysis creep_analysis;
HIDDEN_END

#endif
