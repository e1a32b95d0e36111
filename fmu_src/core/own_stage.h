/* What the stages share that are generated from an effect of the user's own (python/it2hys/fmu/own_stage.py).
 * Nothing includes it where there is none. */
#ifndef IT2HYS_OWN_STAGE_H
#define IT2HYS_OWN_STAGE_H

#include "stage.h"

/* The input is sought within the range, then within this share of it beyond each end: an end of that is out of
 * the range, so that the chain's inverse is saturated where nothing makes the output. */
#define OWN_BEYOND REAL(0.5)

/* Halving alone takes 53 to the last digit; and steps that are less than that of the bracket are rounding. */
enum { OWN_SEARCH_STEPS = 60, OWN_GRID = 64 };
#define OWN_ROUNDING (4 * REAL_EPSILON)

static const struct stage_surroundings OWN_AT_REST = { 0, REAL(293.15), 0, 0 };

/* Of `step`, which it does not take: the output at the input x, and its derivative by x. */
typedef real own_curve(const void *constants, const void *state, real x,
                       const struct stage_surroundings *around, real *slope);

/* Where the range has no ends, ends between which the curve that rises has the value y. */
static inline void own_bracket(own_curve *curve, const void *constants, const void *state, real y,
                               const struct stage_surroundings *around, real *first, real *last)
{
    real slope, width = real_fmax(real_fabs(y), REAL(1e-6));

    *first = *last = y;
    for (int i = 0; i < OWN_SEARCH_STEPS; i++, width *= 2) {
        const bool low = curve(constants, state, *first, around, &slope) > y;
        const bool high = curve(constants, state, *last, around, &slope) < y;
        if (!low && !high)
            return;
        *first -= low ? width : 0;
        *last += high ? width : 0;
    }
}

/* The farthest that an input is sought beyond the ends of a range. */
static inline real own_beyond(real minimum, real maximum)
{
    return OWN_BEYOND * (maximum - minimum);
}

/* Where a curve that rises over the range has the value y: within the range if that is there, otherwise beyond it
 * or at the farthest that it is sought. Newton's method within a bracket that every step narrows, which is halved
 * instead where Newton would leave it or does not halve its own step. */
static inline real own_search(own_curve *curve, const void *constants, const void *state, real y,
                              const struct stage_surroundings *around, real minimum, real maximum)
{
    real low = minimum, high = maximum, slope;

    if (!(minimum < maximum && maximum - minimum < REAL_MAX)) {
        own_bracket(curve, constants, state, y, around, &low, &high);
    } else if (curve(constants, state, minimum, around, &slope) > y) {
        low = minimum - own_beyond(minimum, maximum);
        high = minimum;
        if (curve(constants, state, low, around, &slope) >= y)
            return low;
    } else if (curve(constants, state, maximum, around, &slope) < y) {
        low = maximum;
        high = maximum + own_beyond(minimum, maximum);
        if (curve(constants, state, high, around, &slope) <= y)
            return high;
    }
    const real rounding = OWN_ROUNDING * (high - low);
    real x = clamp(y, low, high), step = high - low;
    for (int i = 0; i < OWN_SEARCH_STEPS; i++) {
        const real excess = curve(constants, state, x, around, &slope) - y;
        const real newton = -excess / slope;
        if (real_fabs(newton) <= rounding)
            return x + newton;
        if (excess > 0)
            high = x;
        else
            low = x;
        const bool well =
            x + newton >= low && x + newton <= high && real_fabs(newton) <= REAL(0.5) * real_fabs(step);
        step = well ? newton : REAL(0.5) * (low + high) - x;
        x += step;
    }
    return x;
}

#endif
