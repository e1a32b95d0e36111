/* Rate-independent memory in front of the core, Prandtl-Ishlinskii: h_k = x_k + sum_j w_j p_j,k with
 * the play operators p_j,k = min(max(p_j,k-1, x_k - r_j), x_k + r_j).
 *
 * Thresholds r_j rise and 1 + w_1 + ... + w_j > 0 for every j: then h rises with x, piecewise linearly,
 * and operators engage in the order of their thresholds (|p_i - p_j| <= |r_i - r_j| holds on from
 * rest). So the inverse walks over at most n + 1 segments. */
#ifndef IT2HYS_PLAY_H
#define IT2HYS_PLAY_H

#include "effect.h"

enum { PLAY_MAX = 16 };

struct play_element {
    double threshold; /* r_j, V */
    double weight;    /* w_j */
};

/* How the operators came to rest at the start: demagnetised at a voltage that much beside the one at rest,
 * where all their outputs are that voltage, then driven from there by the excursion, then to rest. Both 0:
 * demagnetised where the stage rests. */
struct play_history {
    double offset;
    double excursion;
};

struct play {
    int count;
    struct play_element element[PLAY_MAX];
};

struct play_state {
    double p[PLAY_MAX]; /* p_j,k-1 */
};

HIDDEN_BEGIN

bool play_check(const struct play_element *elements, int count, char *message, size_t size);
void play_prepare(struct play *stage, const struct play_element *elements, int count);

/* At rest at the input x after the history. */
void play_recall(const struct play *stage, struct play_state *state, double x,
                 struct play_history history);

/* At rest at the output h after the history; returns the input. */
double play_reset(const struct play *stage, struct play_state *state, double h,
                  struct play_history history);
double play_step(const struct play *stage, struct play_state *state, double x);
double play_inverse(const struct play *stage, struct play_state *state, double h);

/* The input that gives h; the state stays. */
double play_solve(const struct play *stage, const struct play_state *state, double h);

double play_step_tangent(const struct play *stage, const struct play_state *state, double x,
                         struct play_state *d_state, double d_x);

/* Derivative of play_solve where it returns x. */
double play_solve_tangent(const struct play *stage, const struct play_state *state, double x,
                          const struct play_state *d_state, double d_h);

/* Derivative of the input that play_reset returns, in the direction of `d`, d_h and d_history. */
double play_reset_tangent(const struct play *stage, double h, struct play_history history,
                          const struct play_element *d, double d_h, struct play_history d_history);

HIDDEN_END

#endif
