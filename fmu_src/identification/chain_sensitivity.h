/* The chain over a whole record as the identification needs it: from rest at the record's first voltage,
 * and with the derivatives of the reading by everything that is fitted. */
#ifndef IT2HYS_CHAIN_SENSITIVITY_H
#define IT2HYS_CHAIN_SENSITIVITY_H

#include <stdint.h>

#include "chain.h"

struct chain_record {
    const double *voltage;
    const double *force;
    const double *temperature;
    int64_t first_tick;
    size_t samples;
};

/* A parameter of an effect that is fitted: where in struct chain_parameters, whether its effect stands
 * before the core, and by how much it is changed for a difference quotient. */
struct chain_knob {
    size_t offset;
    int before_core;
    double step;
};

enum { CHAIN_MAX_KNOBS = 96 };

HIDDEN_BEGIN

/* The readings, and the core's input and output, from rest at the first voltage after the history that
 * the parameters tell (initialRestOffset, initialExcursion, initialCreep). initialDisplacement is
 * where the search for what the core keeps begins; if it keeps nothing within the range from there, the
 * reading begins there. Returns the number of samples computed: less than all if a reading is not
 * finite. */
size_t chain_predict(const struct chain_parameters *parameters, const struct chain_record *record,
                     double *measured, double *core_input, double *core_output);

/* The same with `sensitivity`: a row per sample with the derivatives by the rules' parameters (in the
 * order of struct it2_rule) and the knobs.
 *
 * The rules' are exact (forward sensitivities), and so is what every stage makes of those before it. By
 * its own parameters each stage is differentiated by central differences: an effect needs no more than
 * its step for that. Only the play operators' weights, which are many, need none. Returns 0 if there is
 * no memory for it. */
size_t chain_sensitivity(const struct chain_parameters *parameters, const struct chain_record *record,
                         const struct chain_knob *knobs, int count, double *measured,
                         double *sensitivity);

HIDDEN_END

#endif
