#include "hum.h"

#include <math.h>

bool hum_check(const struct hum_parameters *parameters, char *message, size_t size)
{
    if (!(parameters->amplitude >= 0.0))
        return refuse(message, size, "hum.amplitude is %g m; it must be positive, or 0 for none",
                      parameters->amplitude);
    if (parameters->amplitude > 0.0 && !(parameters->frequency > 0.0))
        return refuse(message, size, "hum.frequency is %g Hz; with a hum.amplitude it must be positive",
                      parameters->frequency);
    return true;
}

double hum_step(const struct hum_parameters *stage, double y, double time)
{
    return y + stage->amplitude * sin(TWO_PI * stage->frequency * time + stage->phase);
}
