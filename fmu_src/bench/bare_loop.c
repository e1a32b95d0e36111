/* What a sweep cannot be faster than: a bare loop over the FMI functions of inverse and plant.
 *
 *     bare_loop INVERSE.so GUID PLANT.so GUID SCENARIOS TICKS REFERENCES...
 *
 * The last are value references: reference, voltage and saturated of the inverse, voltage and
 * displacement of the plant, initialDisplacement of both. Every scenario resets both instances, sets
 * where they start, initializes, and runs the ticks of
 * a reference that is computed once; voltage, saturation and displacement are recorded. Prints the
 * processor time of all scenarios in s, and a sum that keeps the results alive. benchmarks/sweep.py runs
 * it beside the sweep. */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

#define SAMPLE_TIME 1e-4
#define PI 3.14159265358979323846

struct library {
    fmi2Component instance;
    fmi2ResetTYPE *reset;
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *leave;
    fmi2SetRealTYPE *set_real;
    fmi2GetRealTYPE *get_real;
    fmi2GetBooleanTYPE *get_boolean;
    fmi2DoStepTYPE *do_step;
};

static void *find(void *handle, const char *name)
{
    void *address = dlsym(handle, name);

    if (!address) {
        fprintf(stderr, "bare_loop: no %s\n", name);
        exit(2);
    }
    return address;
}

/* Copies the address of a function: ISO C has no cast from an object's. */
#define FIND(handle, member, name) \
    do { \
        void *address = find(handle, name); \
        memcpy(&(member), &address, sizeof address); \
    } while (0)

static struct library open_library(const char *path, const char *guid)
{
    static const fmi2CallbackFunctions callbacks = { NULL, NULL, NULL, NULL, NULL };
    struct library library;
    fmi2InstantiateTYPE *instantiate;
    void *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);

    if (!handle) {
        fprintf(stderr, "bare_loop: %s\n", dlerror());
        exit(2);
    }
    FIND(handle, instantiate, "fmi2Instantiate");
    FIND(handle, library.reset, "fmi2Reset");
    FIND(handle, library.setup, "fmi2SetupExperiment");
    FIND(handle, library.enter, "fmi2EnterInitializationMode");
    FIND(handle, library.leave, "fmi2ExitInitializationMode");
    FIND(handle, library.set_real, "fmi2SetReal");
    FIND(handle, library.get_real, "fmi2GetReal");
    FIND(handle, library.get_boolean, "fmi2GetBoolean");
    FIND(handle, library.do_step, "fmi2DoStep");
    library.instance = instantiate("bare", fmi2CoSimulation, guid, NULL, &callbacks, fmi2False, fmi2False);
    if (!library.instance) {
        fprintf(stderr, "bare_loop: %s does not instantiate with %s\n", path, guid);
        exit(2);
    }
    return library;
}

static void start(const struct library *fmu, fmi2ValueReference parameter, double value)
{
    fmi2Status status = fmu->reset(fmu->instance);

    status |= fmu->setup(fmu->instance, fmi2False, 0.0, 0.0, fmi2False, 0.0);
    status |= fmu->set_real(fmu->instance, &parameter, 1, &value);
    status |= fmu->enter(fmu->instance);
    status |= fmu->leave(fmu->instance);
    if (status != fmi2OK) {
        fprintf(stderr, "bare_loop: initialization failed\n");
        exit(2);
    }
}

int main(int argc, char **argv)
{
    if (argc != 13) {
        fprintf(stderr, "usage: bare_loop INVERSE.so GUID PLANT.so GUID SCENARIOS TICKS REFERENCES...\n");
        return 2;
    }
    const struct library inverse = open_library(argv[1], argv[2]), plant = open_library(argv[3], argv[4]);
    const long scenarios = atol(argv[5]), ticks = atol(argv[6]);
    fmi2ValueReference vr[6];
    for (int i = 0; i < 6; i++)
        vr[i] = (fmi2ValueReference)atol(argv[7 + i]);
    const fmi2ValueReference desired = vr[0], drive = vr[1], saturated = vr[2], input = vr[3], reached = vr[4],
                             parameter = vr[5];
    const double where = 0.7e-6;
    double *reference = malloc((size_t)ticks * sizeof *reference);
    double *voltage = malloc((size_t)ticks * sizeof *voltage);
    double *displacement = malloc((size_t)ticks * sizeof *displacement);
    double *flags = malloc((size_t)ticks * sizeof *flags);
    double sum = 0.0;
    if (!reference || !voltage || !displacement || !flags)
        return 2;
    for (long k = 0; k < ticks; k++)
        reference[k] = 7.7e-6 - 7e-6 * cos(2.0 * PI * 20.0 * (double)k * SAMPLE_TIME);

    const clock_t began = clock();
    for (long s = 0; s < scenarios; s++) {
        start(&inverse, parameter, where);
        start(&plant, parameter, where);
        for (long k = 0; k < ticks; k++) {
            const double time = (double)k * SAMPLE_TIME;
            fmi2Boolean flag;
            inverse.set_real(inverse.instance, &desired, 1, &reference[k]);
            if (inverse.do_step(inverse.instance, time, SAMPLE_TIME, fmi2True) > fmi2Warning)
                return 2;
            inverse.get_real(inverse.instance, &drive, 1, &voltage[k]);
            inverse.get_boolean(inverse.instance, &saturated, 1, &flag);
            flags[k] = flag;
            plant.set_real(plant.instance, &input, 1, &voltage[k]);
            if (plant.do_step(plant.instance, time, SAMPLE_TIME, fmi2True) > fmi2Warning)
                return 2;
            plant.get_real(plant.instance, &reached, 1, &displacement[k]);
        }
        sum += displacement[ticks - 1] + flags[ticks / 2];
    }
    printf("%.6f %.17g\n", (double)(clock() - began) / CLOCKS_PER_SEC, sum);
    return 0;
}
