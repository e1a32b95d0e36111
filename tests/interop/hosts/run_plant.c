/* A host for the plant's binary, run under wine or qemu: prints the displacement at every tick, in hexadecimal.
 *
 *     run_plant IT2Plant.dll GUID RESOURCE_URI VOLTAGE_REFERENCE DISPLACEMENT_REFERENCE SAMPLE_TIME
 *
 * The voltages are read from the standard input, hexadecimal, one a line. For Windows it is linked with
 * windows_runtime.c in place of MinGW's library, which takes zig a minute to build. */
#include <stdio.h>
#include <stdlib.h>
#if defined _WIN32
#include <windows.h>
#define OPEN(path) LoadLibraryA(path)
#define SYMBOL(library, name) GetProcAddress(library, name)
typedef HMODULE handle;
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW)
#define SYMBOL(library, name) dlsym(library, name)
typedef void *handle;
#endif

#include "fmi2Functions.h"

static void print_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                          fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)name, (void)status, (void)category;
    puts(message);
}

static void expect_ok(fmi2Status status, const char *what)
{
    if (status <= fmi2Warning)
        return;
    puts(what);
    exit(1);
}

#define LOAD(function) \
    function##TYPE *function = (function##TYPE *)(void *)SYMBOL(library, #function)
#define CALL(function, ...) expect_ok(function(__VA_ARGS__), #function)

static int run(int argc, char **argv)
{
    const handle library = argc == 7 ? OPEN(argv[1]) : NULL;

    if (!library) {
        puts("the library cannot be loaded");
        return 1;
    }
    LOAD(fmi2Instantiate);
    LOAD(fmi2SetupExperiment);
    LOAD(fmi2EnterInitializationMode);
    LOAD(fmi2ExitInitializationMode);
    LOAD(fmi2SetReal);
    LOAD(fmi2GetReal);
    LOAD(fmi2DoStep);
    LOAD(fmi2FreeInstance);
    const fmi2CallbackFunctions callbacks = { .logger = print_message,
                                              .allocateMemory = calloc,
                                              .freeMemory = free };
    const fmi2Component c =
        fmi2Instantiate("plant", fmi2CoSimulation, argv[2], argv[3], &callbacks, fmi2False, fmi2True);
    const fmi2ValueReference voltage = strtoul(argv[4], NULL, 10);
    const fmi2ValueReference displacement = strtoul(argv[5], NULL, 10);
    const double sample_time = strtod(argv[6], NULL);
    char line[64];

    if (!c)
        return 1;
    CALL(fmi2SetupExperiment, c, fmi2False, 0.0, 0.0, fmi2False, 0.0);
    CALL(fmi2EnterInitializationMode, c);
    CALL(fmi2ExitInitializationMode, c);
    for (int tick = 0; fgets(line, sizeof line, stdin); tick++) {
        double value = strtod(line, NULL);
        CALL(fmi2SetReal, c, &voltage, 1, &value);
        CALL(fmi2DoStep, c, tick * sample_time, sample_time, fmi2True);
        CALL(fmi2GetReal, c, &displacement, 1, &value);
        snprintf(line, sizeof line, "%a", value);
        puts(line);
    }
    fmi2FreeInstance(c);
    return 0;
}

#if defined _WIN32
int _configure_narrow_argv(int mode); /* of Windows' C library; MinGW declares it nowhere */

void mainCRTStartup(void)
{
    _configure_narrow_argv(1); /* the arguments as they are, wildcards not expanded */
    exit(run(*__p___argc(), *__p___argv()));
}
#else
int main(int argc, char **argv)
{
    return run(argc, argv);
}
#endif
