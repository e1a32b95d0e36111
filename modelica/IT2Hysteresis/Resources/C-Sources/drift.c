#include "drift.h"

bool drift_is_on(const struct drift_parameters *parameters)
{
    return parameters->temperatureCoefficient != 0.0 || parameters->rate != 0.0;
}

static double offset(const struct drift_parameters *stage, double temperature, double time)
{
    return stage->temperatureCoefficient * (temperature - DRIFT_REFERENCE_TEMPERATURE) +
           stage->rate * time;
}

double drift_step(const struct drift_parameters *stage, double x, double temperature, double time)
{
    return x + offset(stage, temperature, time);
}

double drift_inverse(const struct drift_parameters *stage, double y, double temperature, double time)
{
    return y - offset(stage, temperature, time);
}

double drift_step_tangent(const struct drift_parameters *stage, double d_x, double d_temperature)
{
    return d_x + stage->temperatureCoefficient * d_temperature;
}

double drift_inverse_tangent(const struct drift_parameters *stage, double d_y, double d_temperature)
{
    return d_y - stage->temperatureCoefficient * d_temperature;
}
