/* What makes a parameter set usable. */
#include "chain.h"

/* How far beyond the range a run may begin, in lengths of the range: a stage is not farther away, and a
 * displacement in another unit is. */
#define FARTHEST_START 4

/* For parameters that have passed all other checks. */
static bool check_start(const struct chain_parameters *p, char *message, size_t size)
{
    const real reach = FARTHEST_START * (p->displacementMax - p->displacementMin);
    struct chain chain;
    struct chain_state state;

    chain_prepare(&chain, p);
    chain_reset(&chain, &state, p);
    if (state.core.y >= p->displacementMin - reach && state.core.y <= p->displacementMax + reach)
        return true;
    return refuse(message, size,
                  "initialDisplacement is %g m: the run would begin more than %g times the length of "
                  "displacementMin..displacementMax, %g to %g m, outside it; set it to where the stage is "
                  "(is it in another unit?)",
                  (double)p->initialDisplacement, (double)FARTHEST_START, (double)p->displacementMin,
                  (double)p->displacementMax);
}

static bool check_stages(const struct chain_parameters *p, char *message, size_t size)
{
    for (int i = 0; i < CHAIN_STAGE_COUNT; i++)
        if (CHAIN_ANALYSES[i]->check && !CHAIN_ANALYSES[i]->check(p, message, size))
            return false;
    return true;
}

bool chain_check(const struct chain_parameters *parameters, char *message, size_t size)
{
    const struct it2_range range = { parameters->displacementMin, parameters->displacementMax };

    if (!(parameters->sampleTime > 0))
        return refuse(message, size, "sampleTime is %g s; it must be positive", (double)parameters->sampleTime);
    if (!(parameters->voltageMin < parameters->voltageMax))
        return refuse(message, size, "voltageMin, %g V, must be below voltageMax, %g V",
                      (double)parameters->voltageMin, (double)parameters->voltageMax);
    return it2_check(parameters->rule, parameters->ruleCount, range, message, size) &&
           check_stages(parameters, message, size) && check_start(parameters, message, size);
}
