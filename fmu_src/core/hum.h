/* A line on the reading that is not in the voltage: hum.amplitude sin(2 pi hum.frequency t_k + hum.phase).
 *
 * t_k is the tick's own time. Plant only, on `measured` only. No state. */
#ifndef IT2HYS_HUM_H
#define IT2HYS_HUM_H

#include "effect.h"

struct hum_parameters {
    double amplitude; /* m; 0: none */
    double frequency; /* Hz */
    double phase;     /* rad */
};

HIDDEN_BEGIN

bool hum_check(const struct hum_parameters *parameters, char *message, size_t size);
double hum_step(const struct hum_parameters *stage, double y, double time);

HIDDEN_END

#endif
