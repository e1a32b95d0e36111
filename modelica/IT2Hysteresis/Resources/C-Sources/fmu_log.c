#include <stdio.h>
#include <string.h>

#include "fmu.h"

static const struct {
    const char *name;
    unsigned categories;
} CATEGORIES[] = {
    { "logEvents", FMU_LOG_EVENTS },        { "logStatusWarning", FMU_LOG_WARNING },
    { "logStatusDiscard", FMU_LOG_DISCARD }, { "logStatusError", FMU_LOG_ERROR },
    { "logAll", FMU_LOG_ALL },
};
enum { CATEGORY_COUNT = sizeof CATEGORIES / sizeof CATEGORIES[0] };

static const char *phase_name(int phase)
{
    switch (phase) {
    case FMU_INSTANTIATED: return "instantiated";
    case FMU_INITIALIZATION: return "initializationMode";
    case FMU_STEP_COMPLETE: return "stepComplete";
    default: return "terminated";
    }
}

/* The logger takes a printf format: a percent sign of the message must not act as one. */
static void escape_percent(const char *text, char *escaped, size_t size)
{
    size_t n = 0;

    for (; *text && n + 2 < size; text++) {
        if (*text == '%')
            escaped[n++] = '%';
        escaped[n++] = *text;
    }
    escaped[n] = '\0';
}

fmi2Status fmu_say(const struct fmu *fmu, fmi2Status status, const char *format, ...)
{
    static const int category_of[] = { [fmi2OK] = 0, [fmi2Warning] = 1, [fmi2Discard] = 2,
                                       [fmi2Error] = 3 };
    const int category = category_of[status];
    char text[1024];
    char escaped[2 * sizeof text];
    va_list arguments;

    if (!fmu->logger || !(fmu->categories & CATEGORIES[category].categories))
        return status;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    escape_percent(text, escaped, sizeof escaped);
    fmu->logger(fmu->environment, fmu->name, status, CATEGORIES[category].name, escaped);
    return status;
}

bool fmu_refuse(const struct fmu *fmu, const char *function)
{
    if (fmu)
        fmu_say(fmu, fmi2Error, "%s: not allowed in the state %s; this instance is left as it is.",
                function, phase_name(fmu->now.phase));
    return false;
}

fmi2Status fmu_set_debug_logging(struct fmu *fmu, bool on, size_t count, const fmi2String categories[])
{
    unsigned chosen = count == 0 ? FMU_LOG_ALL : 0;

    if (!fmu_may(fmu, "fmi2SetDebugLogging", FMU_ANY_PHASE))
        return fmi2Error;
    if (count > 0 && !categories)
        return fmu_say(fmu, fmi2Error, "fmi2SetDebugLogging: categories is a null pointer.");
    for (size_t i = 0; i < count; i++) {
        int k = 0;
        while (k < CATEGORY_COUNT && categories[i] && strcmp(categories[i], CATEGORIES[k].name) != 0)
            k++;
        if (k == CATEGORY_COUNT || !categories[i])
            return fmu_say(fmu, fmi2Error,
                           "fmi2SetDebugLogging: unknown log category '%s'; known are logEvents, "
                           "logStatusWarning, logStatusDiscard, logStatusError and logAll.",
                           categories[i] ? categories[i] : "(null)");
        chosen |= CATEGORIES[k].categories;
    }
    if (on)
        fmu->categories |= chosen;
    else
        fmu->categories &= ~chosen;
    return fmi2OK;
}
