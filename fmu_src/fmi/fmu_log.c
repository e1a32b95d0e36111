#include <stdio.h>
#include <string.h>

#include "fmu.h"

/* In the order of enum fmu_status, and all of them. */
static const struct {
    const char *name;
    unsigned category;
} CATEGORIES[] = {
    [FMU_OK] = { "logEvents", FMU_LOG_EVENTS },
    [FMU_WARNING] = { "logStatusWarning", FMU_LOG_WARNING },
    [FMU_DISCARD] = { "logStatusDiscard", FMU_LOG_DISCARD },
    [FMU_ERROR] = { "logStatusError", FMU_LOG_ERROR },
    { "logAll", FMU_LOG_ALL },
};
enum { CATEGORY_COUNT = sizeof CATEGORIES / sizeof CATEGORIES[0] };

static const char *phase_name(int phase)
{
    switch (phase) {
    case FMU_INSTANTIATED: return "instantiated";
    case FMU_INITIALIZATION: return "initializationMode";
    case FMU_STEP_COMPLETE: return "stepComplete";
    case FMU_CONFIGURATION: return "configurationMode";
    case FMU_UPDATE: return "intermediateUpdateMode";
    default: return "terminated";
    }
}

static enum fmu_status hand_over(const struct fmu_host *host, const char *name, enum fmu_status status,
                                 const char *text)
{
    host->log(host, name, status, CATEGORIES[status].name, text);
    return status;
}

enum fmu_status fmu_say(const struct fmu *fmu, enum fmu_status status, const char *format, ...)
{
    char text[1024];
    va_list arguments;

    if (!fmu->host.log || !(fmu->categories & CATEGORIES[status].category))
        return status;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return hand_over(&fmu->host, fmu->name, status, text);
}

enum fmu_status fmu_say_early(const struct fmu_host *host, const char *name, const char *text)
{
    return host->log ? hand_over(host, name, FMU_ERROR, text) : FMU_ERROR;
}

bool fmu_refuse(const struct fmu *fmu, const char *function)
{
    if (fmu)
        fmu_say(fmu, FMU_ERROR, "%s: not allowed in the state %s; this instance is left as it is.", function,
                phase_name(fmu->now->phase));
    return false;
}

enum fmu_status fmu_lacks(const struct fmu *fmu, const char *function)
{
    return fmu_say(fmu, FMU_ERROR, "%s: not supported, as the model description says.", function);
}

enum fmu_status fmu_set_debug_logging(struct fmu *fmu, const char *function, bool on, size_t count,
                                      const char *const categories[])
{
    unsigned chosen = count == 0 ? FMU_LOG_ALL : 0;

    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (count > 0 && !categories)
        return fmu_say(fmu, FMU_ERROR, "%s: categories is a null pointer.", function);
    for (size_t i = 0; i < count; i++) {
        int k = 0;
        while (k < CATEGORY_COUNT && categories[i] && strcmp(categories[i], CATEGORIES[k].name) != 0)
            k++;
        if (k == CATEGORY_COUNT || !categories[i])
            return fmu_say(fmu, FMU_ERROR,
                           "%s: unknown log category '%s'; known are logEvents, logStatusWarning, "
                           "logStatusDiscard, logStatusError and logAll.",
                           function, categories[i] ? categories[i] : "(null)");
        chosen |= CATEGORIES[k].category;
    }
    if (on)
        fmu->categories |= chosen;
    else
        fmu->categories &= ~chosen;
    return FMU_OK;
}
