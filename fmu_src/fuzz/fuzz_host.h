/* The host of fuzzed FMUs. */
#ifndef FUZZ_HOST_H
#define FUZZ_HOST_H

#include <stdarg.h>
#include <stdio.h>

#include "fmi2FunctionTypes.h"
#include "fuzz.h"

/* Formats every message, as a host does. */
static void log_message(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                        fmi2String category, fmi2String message, ...)
{
    char text[2048];
    va_list arguments;

    (void)environment;
    FUZZ_PROMISE(instance && category && status <= fmi2Error);
    va_start(arguments, message);
    FUZZ_PROMISE(vsnprintf(text, sizeof text, message, arguments) >= 0);
    va_end(arguments);
}

static const fmi2CallbackFunctions HOST = { log_message, NULL, NULL, NULL, NULL };

#endif
