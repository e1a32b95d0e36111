#include "saturation.h"

bool saturation_check(const struct saturation_parameters *parameters, char *message, size_t size)
{
    if (parameters->minimum == 0.0 && parameters->maximum == 0.0)
        return true;
    if (!(parameters->minimum < parameters->maximum))
        return refuse(message, size, "saturation.minimum, %g V, must be below saturation.maximum, %g V "
                      "(both 0: no saturation)", parameters->minimum, parameters->maximum);
    return true;
}

bool saturation_is_on(const struct saturation_parameters *parameters)
{
    return parameters->minimum < parameters->maximum;
}

double saturation_step(const struct saturation_parameters *stage, double x)
{
    return clamp(x, stage->minimum, stage->maximum);
}

double saturation_step_tangent(const struct saturation_parameters *stage, double x, double d_x)
{
    return x < stage->minimum || x > stage->maximum ? 0.0 : d_x;
}

double saturation_inverse(const struct saturation_parameters *stage, double y)
{
    return saturation_step(stage, y);
}
