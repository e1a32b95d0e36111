#include "nonlinearity.h"

#define GRID 256

bool nonlinearity_is_on(const struct nonlinearity_parameters *parameters)
{
    return parameters->quadratic != 0.0 || parameters->cubic != 0.0 || parameters->quartic != 0.0;
}

void nonlinearity_prepare(struct nonlinearity *stage, const struct nonlinearity_parameters *parameters)
{
    stage->coefficient = *parameters;
    stage->centre = 0.5 * (parameters->minimum + parameters->maximum);
    stage->half_range = 0.5 * (parameters->maximum - parameters->minimum);
}

double nonlinearity_step(const struct nonlinearity *stage, double y)
{
    const struct nonlinearity_parameters *c = &stage->coefficient;
    const double z = clamp((y - stage->centre) / stage->half_range, -1.0, 1.0);

    return y + (1.0 - z * z) * (c->quadratic + z * (c->cubic + z * c->quartic));
}

/* On the curve between the ends, by y. */
static double slope(const struct nonlinearity *stage, double z)
{
    const struct nonlinearity_parameters *c = &stage->coefficient;
    const double by_z = -2.0 * z * (c->quadratic + z * (c->cubic + z * c->quartic)) +
                        (1.0 - z * z) * (c->cubic + 2.0 * z * c->quartic);

    return 1.0 + by_z / stage->half_range;
}

double nonlinearity_derivative(const struct nonlinearity *stage, double y)
{
    const double z = (y - stage->centre) / stage->half_range;

    return z < -1.0 || z > 1.0 ? 1.0 : slope(stage, z);
}

bool nonlinearity_check(const struct nonlinearity_parameters *parameters, char *message, size_t size)
{
    struct nonlinearity stage;

    if (!nonlinearity_is_on(parameters))
        return true;
    if (!(parameters->minimum < parameters->maximum))
        return refuse(message, size, "nonlinearity.minimum, %g m, must be below nonlinearity.maximum, "
                      "%g m", parameters->minimum, parameters->maximum);
    nonlinearity_prepare(&stage, parameters);
    for (int i = 0; i <= GRID; i++) {
        const double z = 2.0 * i / GRID - 1.0;
        if (!(slope(&stage, z) > 0.0))
            return refuse(message, size, "nonlinearity.quadratic, cubic and quartic make a curve that "
                          "falls at a displacement of %g; it must rise from nonlinearity.minimum "
                          "to nonlinearity.maximum", stage.centre + z * stage.half_range);
    }
    return true;
}
