/* Creep: y_k = x_k + sum_i c_i s_i,k with s_i,k = s_i,k-1 + g_i (x_k - s_i,k-1), g_i = 1 - exp(-Ts / tau_i).
 *
 * s_i at tick k includes x_k, so that a stage much faster than Ts is a plain gain. y is affine in x
 * with the slope 1 + sum_i c_i g_i. The inverse is stable where 1 + the sum of the negative gains is
 * positive. Linear: x and y are counted from the sensor's zero. */
#ifndef IT2HYS_CREEP_H
#define IT2HYS_CREEP_H

#include "effect.h"

enum { CREEP_MAX = 16 };

struct creep_element {
    double gain;         /* c_i: creep in the end, per displacement */
    double timeConstant; /* tau_i, s */
};

struct creep {
    int count;
    double gain[CREEP_MAX]; /* c_i */
    double rate[CREEP_MAX]; /* g_i */
    double slope;           /* dy_k / dx_k */
};

struct creep_state {
    double s[CREEP_MAX]; /* s_i,k-1 */
};

HIDDEN_BEGIN

bool creep_check(const struct creep_element *elements, int count, char *message, size_t size);
void creep_prepare(struct creep *stage, const struct creep_element *elements, int count,
                   double sample_time);

/* At the output y with states that lie `ahead` of the input, by 0 after long rest; returns the input. */
double creep_reset(const struct creep *stage, struct creep_state *state, double y, double ahead);
double creep_step(const struct creep *stage, struct creep_state *state, double x);
double creep_inverse(const struct creep *stage, struct creep_state *state, double y);

/* The input that gives y; the state stays. */
double creep_solve(const struct creep *stage, const struct creep_state *state, double y);

/* Derivative of the input x that creep_reset returns, in the direction of `d`, d_y and d_ahead. */
double creep_reset_tangent(const struct creep *stage, double x, double ahead,
                           const struct creep_element *d, double d_y, double d_ahead);

HIDDEN_END

#endif
