/* Rate-independent memory in front of the core, Prandtl-Ishlinskii: h_k = x_k + sum_j w_j p_j,k with
 * the play operators p_j,k = min(max(p_j,k-1, x_k - r_j), x_k + r_j).
 *
 * Thresholds r_j rise and 1 + w_1 + ... + w_j > 0 for every j: then h rises with x, piecewise linearly,
 * and operators engage in the order of their thresholds (|p_i - p_j| <= |r_i - r_j| holds on from
 * rest). So the inverse walks over at most n + 1 segments.
 *
 * How the operators came to rest at the start: demagnetised at initialDemagnetisation, where all their outputs
 * are that voltage, then driven from there by initialExcursion, then to where the stage rests. Both 0: on the
 * initial loading curve of a new stage. */
#ifndef IT2HYS_PLAY_H
#define IT2HYS_PLAY_H

#include "stage.h"

enum { PLAY_MAX = 32 };

struct play_element {
    real threshold; /* r_j, V */
    real weight;    /* w_j */
};

typedef struct play_element play_parameters[PLAY_MAX];

struct play {
    int first; /* of derivatives: those before are 0 */
    int count;
    struct play_element element[PLAY_MAX];
};

struct play_state {
    real p[PLAY_MAX]; /* p_j,k-1 */
};

HIDDEN_BEGIN
extern const struct stage play_stage;
extern const struct stage_analysis play_analysis;
HIDDEN_END

#endif
