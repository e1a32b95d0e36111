/* The chain over a whole record as the identification needs it: with the derivatives of the reading by
 * everything that is fitted, the state in which the record begins included. */
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

enum { CHAIN_MAX_KNOBS = 160 };

HIDDEN_BEGIN

/* The readings, and the core's input and output unless that is NULL, begun by chain_reset as the plant FMU is.
 * Returns the number of samples computed: less than all if a reading is not finite. */
size_t chain_predict(const struct chain_parameters *parameters, const struct chain_record *record,
                     double *measured, double *core_input, double *core_output);

/* The same with `sensitivity`: a row per sample with the derivatives by the rules' parameters (in the
 * order of struct it2_rule) where `by_rules` asks for them, and by the Real parameters at these places in
 * struct chain_parameters.
 *
 * All are exact: forward sensitivities, by the stages' tangents. By a parameter at which the reading has a
 * corner the derivative is that of one side, or the mean of both. Returns 0 if there is no memory for it. */
size_t chain_sensitivity(const struct chain_parameters *parameters, const struct chain_record *record,
                         bool by_rules, const size_t *places, int count, double *measured, double *sensitivity);

HIDDEN_END

#endif
