#include "nonlinearity.h"

#include "chain.h"

#define CURVE_GRID 256

/* Of the inverse: 3 to 8 are usual, halving alone takes 53 to the last digit. */
#define MOST_STEPS 120

static bool nonlinearity_is_on(const struct chain_parameters *p)
{
    const struct nonlinearity_parameters *c = &p->nonlinearity;

    return c->quadratic != 0 || c->cubic != 0 || c->quartic != 0 || c->quintic != 0 || c->sextic != 0;
}

/* The curve, or its derivative, which is linear in the parameters. */
static void nonlinearity_set(struct nonlinearity *curve, const struct chain_parameters *p)
{
    const struct nonlinearity_parameters *c = &p->nonlinearity;

    curve->coefficient = *c;
    curve->centre = p->displacementZero + REAL(0.5) * (c->minimum + c->maximum);
    curve->half_range = REAL(0.5) * (c->maximum - c->minimum);
}

/* What the curve adds to the straight line, and its derivative by z. */
struct nonlinearity_bow {
    real value;
    real slope;
};

/* Between the ends, z from -1 to 1: (1 - z^2) times a polynomial, of pairs that do not wait for each other. */
static inline struct nonlinearity_bow nonlinearity_bow(const struct nonlinearity_parameters *c, real z)
{
    const real z2 = z * z, ends = 1 - z2;
    const real inner = (c->quadratic + c->cubic * z) + ((c->quartic + c->quintic * z) + c->sextic * z2) * z2;
    const real by_z = (c->cubic + 2 * c->quartic * z) + (3 * c->quintic + 4 * c->sextic * z) * z2;

    return (struct nonlinearity_bow){ ends * inner, ends * by_z - 2 * z * inner };
}

/* The same numbers, sooner, where the curve is at most cubic: an inverse waits for each of these. */
static inline struct nonlinearity_bow nonlinearity_bow_of(bool cubic, const struct nonlinearity_parameters *c,
                                                          real z)
{
    const real ends = 1 - z * z, inner = c->quadratic + c->cubic * z;

    if (!cubic)
        return nonlinearity_bow(c, z);
    return (struct nonlinearity_bow){ ends * inner, ends * c->cubic - 2 * z * inner };
}

/* Where z + bow(z) = aim, to the first order in the bow. */
static inline real nonlinearity_guess(bool cubic, const struct nonlinearity_parameters *c, real aim)
{
    const struct nonlinearity_bow bow = nonlinearity_bow_of(cubic, c, aim);

    return aim - bow.value * (1 - bow.slope);
}

/* How many steps of Newton's method solve a curve from that guess, whatever the aim is, to rounding; 0 where that is
 * not sure. From the aim to where z + bow(z) = aim it is d = -bow(z), and the guess is off by at most
 * tilt^2 |d| + bend d^2: tilt bounds |dbow/dz|, bend half the second derivative. A step leaves the square of what
 * it finds, times bend / (1 - tilt), where z may be somewhat beyond the ends, up to |z| = 1.3. */
static int nonlinearity_steps(const struct nonlinearity_parameters *c)
{
    const real q = real_fabs(c->quadratic), k = real_fabs(c->cubic), l = real_fabs(c->quartic);
    const real m = real_fabs(c->quintic), n = real_fabs(c->sextic);
    const real d = q + REAL(0.4) * k + REAL(0.25) * l + REAL(0.19) * m + REAL(0.15) * n;
    const real tilt = 2 * (q + k + l + m + n), bend = q + 3 * k + 5 * l + 7 * m + 9 * n;
    const real tilt_beyond = 3 * q + 5 * k + 7 * l + 10 * m + 14 * n;
    const real bend_beyond = q + 4 * k + 10 * l + 19 * m + 33 * n;
    real error = (tilt * tilt + bend * d) * d;

    if (!(tilt_beyond <= REAL(0.5) && error <= REAL(0.1)))
        return 0;
    for (int steps = 1;; steps++) {
        error *= bend_beyond / (1 - tilt_beyond) * error;
        if (error <= REAL(0.25) * REAL_EPSILON)
            return steps;
    }
}

static void nonlinearity_prepare(void *constants, const struct chain_parameters *p)
{
    struct nonlinearity *curve = constants;
    struct nonlinearity_parameters *scaled = &curve->scaled;

    nonlinearity_set(curve, p);
    curve->per_half_range = 1 / curve->half_range;
    scaled->quadratic = curve->coefficient.quadratic / curve->half_range;
    scaled->cubic = curve->coefficient.cubic / curve->half_range;
    scaled->quartic = curve->coefficient.quartic / curve->half_range;
    scaled->quintic = curve->coefficient.quintic / curve->half_range;
    scaled->sextic = curve->coefficient.sextic / curve->half_range;
    curve->cubic = p->nonlinearity.quartic == 0 && p->nonlinearity.quintic == 0 && p->nonlinearity.sextic == 0;
    curve->steps = nonlinearity_steps(scaled);
}

static real nonlinearity_step(const void *constants, void *state, real x,
                              const struct stage_surroundings *around)
{
    const struct nonlinearity *curve = constants;
    const real z = (x - curve->centre) * curve->per_half_range;
    const real end = clamp(z, -1, 1);

    (void)state, (void)around;
    if (z != end)
        return x + nonlinearity_bow(&curve->coefficient, end).slope * (z - end);
    return x + nonlinearity_bow_of(curve->cubic, &curve->coefficient, z).value;
}

/* On the curve between the ends, by x. */
static real nonlinearity_slope(const struct nonlinearity *curve, real z)
{
    return 1 + nonlinearity_bow(&curve->coefficient, z).slope / curve->half_range;
}

/* How far the curve at z is above the aim, and what Newton's method adds to z then. */
struct nonlinearity_miss {
    real excess;
    real newton;
};

static inline struct nonlinearity_miss nonlinearity_miss(bool cubic, const struct nonlinearity *curve, real z,
                                                         real aim)
{
    const struct nonlinearity_bow bow = nonlinearity_bow_of(cubic, &curve->scaled, z);
    const real excess = z - aim + bow.value;

    return (struct nonlinearity_miss){ excess, -excess / (1 + bow.slope) };
}

/* Newton's method in z within a bracket that every step narrows, which is halved instead where Newton would
 * leave it or does not halve its own step. */
static real nonlinearity_search(const struct nonlinearity *curve, real aim)
{
    real low = -1, high = 1, z = aim, step = 2;

    for (int i = 0; i < MOST_STEPS; i++) {
        const struct nonlinearity_miss miss = nonlinearity_miss(false, curve, z, aim);
        if (real_fabs(miss.excess) <= REAL_EPSILON)
            break;
        if (miss.excess > 0)
            high = z;
        else
            low = z;
        const bool well = z + miss.newton >= low && z + miss.newton <= high &&
                          real_fabs(miss.newton) <= REAL(0.5) * real_fabs(step);
        step = well ? miss.newton : REAL(0.5) * (low + high) - z;
        if (z + step == z)
            break;
        z += step;
    }
    return z;
}

/* A curve that bends little takes a number of steps that is known before: nothing has to be decided. */
static inline real nonlinearity_solve(bool cubic, const struct nonlinearity *curve, real aim)
{
    real z = nonlinearity_guess(cubic, &curve->scaled, aim);

    for (int i = 0; i < curve->steps; i++)
        z += nonlinearity_miss(cubic, curve, z, aim).newton;
    return curve->centre + curve->half_range * z;
}

static real nonlinearity_inverse(const void *constants, void *state, real y,
                                 const struct stage_surroundings *around)
{
    const struct nonlinearity *curve = constants;
    const real aim = (y - curve->centre) * curve->per_half_range;

    (void)state, (void)around;
    if (!(aim > -1 && aim < 1)) {
        const real end = clamp(aim, -1, 1);
        return curve->centre + curve->half_range * (end + (aim - end) / nonlinearity_slope(curve, end));
    }
    if (curve->steps == 0)
        return curve->centre + curve->half_range * nonlinearity_search(curve, aim);
    return curve->cubic ? nonlinearity_solve(true, curve, aim) : nonlinearity_solve(false, curve, aim);
}

static real nonlinearity_rest(const void *constants, void *state, real y, const struct chain_parameters *p)
{
    (void)p;
    return nonlinearity_inverse(constants, state, y, NULL);
}

static void nonlinearity_prepare_tangent(void *d_constants, const void *constants,
                                         const struct chain_parameters *p, const struct chain_parameters *d)
{
    (void)constants, (void)p;
    nonlinearity_set(d_constants, d);
}

static real nonlinearity_place(const struct nonlinearity *curve, real x)
{
    return (x - curve->centre) / curve->half_range;
}

static real nonlinearity_derivative(const struct nonlinearity *curve, real x)
{
    return nonlinearity_slope(curve, clamp(nonlinearity_place(curve, x), -1, 1));
}

static void nonlinearity_tangent(const void *constants, const void *state, real x,
                                 const struct stage_surroundings *around,
                                 const struct stage_surroundings *d_around, int count, real *restrict d_state,
                                 real *restrict row)
{
    const real slope = nonlinearity_derivative(constants, x);

    (void)around, (void)state, (void)d_around, (void)d_state;
    for (int c = 0; c < count; c++)
        row[c] *= slope;
}

static real nonlinearity_by_parameters(const void *constants, const void *d_constants, const void *state,
                                       real x, const struct stage_surroundings *around, real *d_state,
                                       int stride)
{
    const struct nonlinearity *curve = constants, *d = d_constants;
    const real z = nonlinearity_place(curve, x), end = clamp(z, -1, 1);

    (void)state, (void)around, (void)d_state, (void)stride;
    const struct nonlinearity_bow d_bow = nonlinearity_bow(&d->coefficient, end);
    return d_bow.value + d_bow.slope * (z - end) -
           (nonlinearity_slope(curve, end) - 1) * (d->centre + z * d->half_range);
}

static real nonlinearity_inverse_tangent(const void *constants, const void *state, real x, void *d_state,
                                         real d_y, const struct stage_surroundings *around,
                                         const struct stage_surroundings *d_around)
{
    (void)around, (void)state, (void)d_state, (void)d_around;
    return d_y / nonlinearity_derivative(constants, x);
}

static real nonlinearity_rest_tangent(const void *constants, const void *d_constants, const void *state,
                                      void *d_state, real x, real d_y, const struct chain_parameters *p,
                                      const struct chain_parameters *d)
{
    const real by = nonlinearity_by_parameters(constants, d_constants, NULL, x, NULL, NULL, 0);

    (void)state, (void)d_state, (void)p, (void)d;
    return (d_y - by) / nonlinearity_derivative(constants, x);
}

static bool nonlinearity_check(const struct chain_parameters *p, char *message, size_t size)
{
    struct nonlinearity curve;

    if (!nonlinearity_is_on(p))
        return true;
    if (!(p->nonlinearity.minimum < p->nonlinearity.maximum))
        return refuse(message, size,
                      "nonlinearity.minimum, %g m, must be below nonlinearity.maximum, "
                      "%g m",
                      (double)p->nonlinearity.minimum, (double)p->nonlinearity.maximum);
    nonlinearity_prepare(&curve, p);
    for (int i = 0; i <= CURVE_GRID; i++) {
        const real z = 2 * (real)i / CURVE_GRID - 1;
        if (!(nonlinearity_slope(&curve, z) > 0))
            return refuse(message, size,
                          "nonlinearity.quadratic to nonlinearity.sextic make a curve that "
                          "falls %g m above displacementZero; it must rise from nonlinearity.minimum "
                          "to nonlinearity.maximum",
                          (double)(curve.centre - p->displacementZero + z * curve.half_range));
    }
    return true;
}

const struct stage nonlinearity_stage = {
    .is_on = nonlinearity_is_on,
    .prepare = nonlinearity_prepare,
    .rest = nonlinearity_rest,
    .step = nonlinearity_step,
    .inverse = nonlinearity_inverse,
};

const struct stage_analysis nonlinearity_analysis = {
    .check = nonlinearity_check,
    .prepare_tangent = nonlinearity_prepare_tangent,
    .rest_tangent = nonlinearity_rest_tangent,
    .tangent = nonlinearity_tangent,
    .by_parameters = nonlinearity_by_parameters,
    .inverse_tangent = nonlinearity_inverse_tangent,
};
