#include "nonlinearity.h"

#include <float.h>
#include <math.h>

#include "chain.h"

#define CURVE_GRID 256

/* Of the inverse: 3 to 8 are usual, halving alone takes 53 to the last digit. */
#define MOST_STEPS 120

static bool nonlinearity_is_on(const struct chain_parameters *p)
{
    const struct nonlinearity_parameters *c = &p->nonlinearity;

    return c->quadratic != 0.0 || c->cubic != 0.0 || c->quartic != 0.0;
}

static void nonlinearity_prepare(void *constants, const struct chain_parameters *p)
{
    const struct nonlinearity_parameters *c = &p->nonlinearity;

    *(struct nonlinearity *)constants =
        (struct nonlinearity){ .coefficient = *c,
                               .centre = p->displacementZero + 0.5 * (c->minimum + c->maximum),
                               .half_range = 0.5 * (c->maximum - c->minimum) };
}

/* Between the ends, z from -1 to 1. */
static double nonlinearity_bow(const struct nonlinearity_parameters *c, double z)
{
    return (1.0 - z * z) * (c->quadratic + z * (c->cubic + z * c->quartic));
}

static double nonlinearity_step(const void *constants, void *state, double x,
                                const struct chain_surroundings *around)
{
    const struct nonlinearity *curve = constants;
    const double z = clamp((x - curve->centre) / curve->half_range, -1.0, 1.0);

    (void)state, (void)around;
    return x + nonlinearity_bow(&curve->coefficient, z);
}

/* On the curve between the ends, by x. */
static double nonlinearity_slope(const struct nonlinearity *curve, double z)
{
    const struct nonlinearity_parameters *c = &curve->coefficient;
    const double by_z = -2.0 * z * (c->quadratic + z * (c->cubic + z * c->quartic)) +
                        (1.0 - z * z) * (c->cubic + 2.0 * z * c->quartic);

    return 1.0 + by_z / curve->half_range;
}

/* Newton's method in z within a bracket that every step narrows, which is halved instead where Newton would
 * leave it or does not halve its own step. */
static double nonlinearity_inverse(const void *constants, void *state, double y,
                                   const struct chain_surroundings *around)
{
    const struct nonlinearity *curve = constants;
    const double aim = (y - curve->centre) / curve->half_range;
    double low = -1.0, high = 1.0, z = aim, step = 2.0;

    (void)state, (void)around;
    if (!(aim > -1.0 && aim < 1.0))
        return y;
    for (int i = 0; i < MOST_STEPS; i++) {
        const double excess = z - aim + nonlinearity_bow(&curve->coefficient, z) / curve->half_range;
        const double newton = -excess / nonlinearity_slope(curve, z);
        if (fabs(excess) <= DBL_EPSILON)
            break;
        if (excess > 0.0)
            high = z;
        else
            low = z;
        const bool well = z + newton >= low && z + newton <= high && fabs(newton) <= 0.5 * fabs(step);
        step = well ? newton : 0.5 * (low + high) - z;
        if (z + step == z)
            break;
        z += step;
    }
    return curve->centre + curve->half_range * z;
}

static double nonlinearity_rest(const void *constants, void *state, double y, const struct chain_parameters *p)
{
    (void)p;
    return nonlinearity_inverse(constants, state, y, NULL);
}

static void nonlinearity_prepare_tangent(void *d_constants, const void *constants,
                                         const struct chain_parameters *p, const struct chain_parameters *d)
{
    (void)constants, (void)p;
    nonlinearity_prepare(d_constants, d);
}

static double nonlinearity_place(const struct nonlinearity *curve, double x)
{
    return (x - curve->centre) / curve->half_range;
}

static double nonlinearity_derivative(const struct nonlinearity *curve, double x)
{
    const double z = nonlinearity_place(curve, x);

    return z < -1.0 || z > 1.0 ? 1.0 : nonlinearity_slope(curve, z);
}

static void nonlinearity_tangent(const void *constants, const void *state, double x,
                                 const struct chain_surroundings *d_around, int count, double *restrict d_state,
                                 double *restrict row)
{
    const double slope = nonlinearity_derivative(constants, x);

    (void)state, (void)d_around, (void)d_state;
    for (int c = 0; c < count; c++)
        row[c] *= slope;
}

static double nonlinearity_by_parameters(const void *constants, const void *d_constants, const void *state,
                                         double x, const struct chain_surroundings *around, double *d_state,
                                         int stride)
{
    const struct nonlinearity *curve = constants, *d = d_constants;
    const double z = nonlinearity_place(curve, x);

    (void)state, (void)around, (void)d_state, (void)stride;
    if (z < -1.0 || z > 1.0)
        return 0.0;
    return nonlinearity_bow(&d->coefficient, z) -
           (nonlinearity_slope(curve, z) - 1.0) * (d->centre + z * d->half_range);
}

static double nonlinearity_inverse_tangent(const void *constants, const void *state, double x, void *d_state,
                                           double d_y, const struct chain_surroundings *d_around)
{
    (void)state, (void)d_state, (void)d_around;
    return d_y / nonlinearity_derivative(constants, x);
}

static double nonlinearity_rest_tangent(const void *constants, const void *d_constants, void *d_state, double x,
                                        double d_y, const struct chain_parameters *p,
                                        const struct chain_parameters *d)
{
    const double by = nonlinearity_by_parameters(constants, d_constants, NULL, x, NULL, NULL, 0);

    (void)d_state, (void)p, (void)d;
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
                      p->nonlinearity.minimum, p->nonlinearity.maximum);
    nonlinearity_prepare(&curve, p);
    for (int i = 0; i <= CURVE_GRID; i++) {
        const double z = 2.0 * i / CURVE_GRID - 1.0;
        if (!(nonlinearity_slope(&curve, z) > 0.0))
            return refuse(message, size,
                          "nonlinearity.quadratic, cubic and quartic make a curve that "
                          "falls %g m above displacementZero; it must rise from nonlinearity.minimum "
                          "to nonlinearity.maximum",
                          curve.centre - p->displacementZero + z * curve.half_range);
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
