#ifndef IT2HYS_CONTROLLER_H
#define IT2HYS_CONTROLLER_H

#include "fmu.h"

/* Names are those of python/it2hys/model/controller.toml. */
struct pi_parameters {
    double sampleTime;
    double proportionalGain;
    double integralGain;
    double voltageMin;
    double voltageMax;
    double initialVoltage;
};

HIDDEN_BEGIN
extern const struct fmu_model controller_model;
HIDDEN_END

#endif
