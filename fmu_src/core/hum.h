/* A line on the reading that is not in the voltage: hum.amplitude sin(2 pi hum.frequency t_k + hum.phase).
 *
 * t_k is the tick's own time. Plant only, on `measured` only. No state. */
#ifndef IT2HYS_HUM_H
#define IT2HYS_HUM_H

#include "stage.h"

typedef struct hum_parameters {
    real amplitude; /* m; 0: none */
    real frequency; /* Hz */
    real phase;     /* rad */
} hum_parameters;

struct hum {
    real amplitude;
    real frequency;
    real phase;
};

HIDDEN_BEGIN
extern const struct stage hum_stage;
extern const struct stage_analysis hum_analysis;
HIDDEN_END

#endif
