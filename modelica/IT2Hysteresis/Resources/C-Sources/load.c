#include "load.h"

bool load_check(const struct load_parameters *parameters, char *message, size_t size)
{
    if (!(parameters->compliance >= 0.0))
        return refuse(message, size, "load.compliance is %g m/N; it must not be negative (force is "
                      "compressive positive)", parameters->compliance);
    return true;
}

double load_step(const struct load_parameters *stage, double x, double force)
{
    return x - stage->compliance * force;
}

double load_inverse(const struct load_parameters *stage, double y, double force)
{
    return y + stage->compliance * force;
}
