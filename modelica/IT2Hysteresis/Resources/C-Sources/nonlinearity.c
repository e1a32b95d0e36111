#include "nonlinearity.h"

#include <float.h>
#include <math.h>

#define GRID 256

/* Of the inverse: 3 to 8 are usual, halving alone takes 53 to the last digit. */
#define MOST_STEPS 120

bool nonlinearity_is_on(const struct nonlinearity_parameters *parameters)
{
    return parameters->quadratic != 0.0 || parameters->cubic != 0.0 || parameters->quartic != 0.0;
}

void nonlinearity_prepare(struct nonlinearity *stage, const struct nonlinearity_parameters *parameters,
                          double zero)
{
    stage->coefficient = *parameters;
    stage->centre = zero + 0.5 * (parameters->minimum + parameters->maximum);
    stage->half_range = 0.5 * (parameters->maximum - parameters->minimum);
}

static double bow(const struct nonlinearity_parameters *c, double z)
{
    return (1.0 - z * z) * (c->quadratic + z * (c->cubic + z * c->quartic));
}

double nonlinearity_step(const struct nonlinearity *stage, double x)
{
    const double z = clamp((x - stage->centre) / stage->half_range, -1.0, 1.0);

    return x + bow(&stage->coefficient, z);
}

/* On the curve between the ends, by x. */
static double slope(const struct nonlinearity *stage, double z)
{
    const struct nonlinearity_parameters *c = &stage->coefficient;
    const double by_z = -2.0 * z * (c->quadratic + z * (c->cubic + z * c->quartic)) +
                        (1.0 - z * z) * (c->cubic + 2.0 * z * c->quartic);

    return 1.0 + by_z / stage->half_range;
}

double nonlinearity_derivative(const struct nonlinearity *stage, double x)
{
    const double z = (x - stage->centre) / stage->half_range;

    return z < -1.0 || z > 1.0 ? 1.0 : slope(stage, z);
}

/* Newton's method in z within a bracket that every step narrows, which is halved instead where Newton would
 * leave it or does not halve its own step. */
double nonlinearity_inverse(const struct nonlinearity *stage, double y)
{
    const double aim = (y - stage->centre) / stage->half_range;
    double low = -1.0, high = 1.0, z = aim, step = 2.0;

    if (!(aim > -1.0 && aim < 1.0))
        return y;
    for (int i = 0; i < MOST_STEPS; i++) {
        const double excess = z - aim + bow(&stage->coefficient, z) / stage->half_range;
        const double newton = -excess / slope(stage, z);
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
    return stage->centre + stage->half_range * z;
}

double nonlinearity_inverse_tangent(const struct nonlinearity *stage, double x,
                                    const struct nonlinearity_parameters *d, double d_zero, double d_y)
{
    const double z = (x - stage->centre) / stage->half_range;

    if (z < -1.0 || z > 1.0)
        return d_y;
    const double d_centre = d_zero + 0.5 * (d->minimum + d->maximum);
    const double d_half_range = 0.5 * (d->maximum - d->minimum);
    const double by_x = slope(stage, z);
    return (d_y - bow(d, z) + (by_x - 1.0) * (d_centre + z * d_half_range)) / by_x;
}

bool nonlinearity_check(const struct nonlinearity_parameters *parameters, char *message, size_t size)
{
    struct nonlinearity stage;

    if (!nonlinearity_is_on(parameters))
        return true;
    if (!(parameters->minimum < parameters->maximum))
        return refuse(message, size, "nonlinearity.minimum, %g m, must be below nonlinearity.maximum, "
                      "%g m", parameters->minimum, parameters->maximum);
    nonlinearity_prepare(&stage, parameters, 0.0);
    for (int i = 0; i <= GRID; i++) {
        const double z = 2.0 * i / GRID - 1.0;
        if (!(slope(&stage, z) > 0.0))
            return refuse(message, size, "nonlinearity.quadratic, cubic and quartic make a curve that "
                          "falls %g m above displacementZero; it must rise from nonlinearity.minimum "
                          "to nonlinearity.maximum", stage.centre + z * stage.half_range);
    }
    return true;
}
