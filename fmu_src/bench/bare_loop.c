/* What a sweep cannot be faster than: a bare loop over the FMI functions of inverse and plant.
 *
 *     bare_loop INVERSE.so GUID PLANT.so GUID SCENARIOS TICKS REFERENCES...
 *
 * The last are value references: reference, voltage and saturated of the inverse; voltage, displacement, outOfRange
 * and rule[1].q2 of the plant; initialDisplacement of both. Every scenario resets both instances, sets where they
 * start and a q2 of its own, initializes, runs the ticks of a reference that is computed once, records four outputs,
 * and makes the numbers of the sweep's row of them. Prints the processor time of all scenarios in s, and the sums of
 * their numbers, e_mr (24), e_rms (25), largest voltage, time saturated, ticks out of range: benchmarks/sweep.py runs
 * it beside the sweep, whose table must have the same. */
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

static void start(const struct library *fmu, const fmi2ValueReference parameters[], size_t count,
                  const double values[])
{
    fmi2Status status = fmu->reset(fmu->instance);

    status |= fmu->setup(fmu->instance, fmi2False, 0.0, 0.0, fmi2False, 0.0);
    status |= fmu->set_real(fmu->instance, parameters, count, values);
    status |= fmu->enter(fmu->instance);
    status |= fmu->leave(fmu->instance);
    if (status != fmi2OK) {
        fprintf(stderr, "bare_loop: initialization failed\n");
        exit(2);
    }
}

/* Outputs of a scenario, at every tick, and what is compared with them. */
struct records {
    double *reference, *voltage, *saturated, *displacement, *outside;
};

/* The row of a sweep's table. */
struct row {
    double e_mr, e_rms, drive, saturated, outside;
};

/* Without what the C library's own does for numbers that are none. */
static double larger(double a, double b)
{
    return a > b ? a : b;
}

static struct row row_of(const struct records *r, long ticks)
{
    struct row row = { .drive = -INFINITY };
    double low = INFINITY, high = -INFINITY, largest = 0.0, squares = 0.0;

    for (long k = 0; k < ticks; k++) {
        const double error = r->reference[k] - r->displacement[k];
        low = -larger(-low, -r->reference[k]);
        high = larger(high, r->reference[k]);
        largest = larger(largest, fabs(error));
        squares += error * error;
        row.drive = larger(row.drive, r->voltage[k]);
        row.saturated += r->saturated[k] != 0.0;
        row.outside += r->outside[k] != 0.0;
    }
    row.e_mr = largest / (high - low);
    row.e_rms = sqrt(squares / (double)ticks);
    row.saturated *= SAMPLE_TIME;
    return row;
}

static void run(const struct library *inverse, const struct library *plant, const fmi2ValueReference vr[],
                const struct records *r, long ticks)
{
    for (long k = 0; k < ticks; k++) {
        const double time = (double)k * SAMPLE_TIME;
        fmi2Boolean flag;
        inverse->set_real(inverse->instance, &vr[0], 1, &r->reference[k]);
        if (inverse->do_step(inverse->instance, time, SAMPLE_TIME, fmi2True) > fmi2Warning)
            exit(2);
        inverse->get_real(inverse->instance, &vr[1], 1, &r->voltage[k]);
        inverse->get_boolean(inverse->instance, &vr[2], 1, &flag);
        r->saturated[k] = flag;
        plant->set_real(plant->instance, &vr[3], 1, &r->voltage[k]);
        if (plant->do_step(plant->instance, time, SAMPLE_TIME, fmi2True) > fmi2Warning)
            exit(2);
        plant->get_real(plant->instance, &vr[4], 1, &r->displacement[k]);
        plant->get_boolean(plant->instance, &vr[5], 1, &flag);
        r->outside[k] = flag;
    }
}

int main(int argc, char **argv)
{
    if (argc != 15) {
        fprintf(stderr, "usage: bare_loop INVERSE.so GUID PLANT.so GUID SCENARIOS TICKS REFERENCES...\n");
        return 2;
    }
    const struct library inverse = open_library(argv[1], argv[2]), plant = open_library(argv[3], argv[4]);
    const long scenarios = atol(argv[5]), ticks = atol(argv[6]);
    fmi2ValueReference vr[8];
    for (int i = 0; i < 8; i++)
        vr[i] = (fmi2ValueReference)atol(argv[7 + i]);
    const size_t size = (size_t)ticks * sizeof(double);
    const struct records r = { malloc(size), malloc(size), malloc(size), malloc(size), malloc(size) };
    struct row sum = { 0 };
    if (!r.reference || !r.voltage || !r.saturated || !r.displacement || !r.outside)
        return 2;
    for (long k = 0; k < ticks; k++)
        r.reference[k] = 7.7e-6 - 7e-6 * cos(2.0 * PI * 20.0 * (double)k * SAMPLE_TIME);

    const clock_t began = clock();
    for (long s = 0; s < scenarios; s++) {
        const double values[] = { 1.9e-8 + 1e-9 * (double)s / (double)(scenarios - 1), 0.7e-6 };
        start(&inverse, &vr[7], 1, &values[1]);
        start(&plant, &vr[6], 2, values);
        run(&inverse, &plant, vr, &r, ticks);
        const struct row row = row_of(&r, ticks);
        sum.e_mr += row.e_mr;
        sum.e_rms += row.e_rms;
        sum.drive += row.drive;
        sum.saturated += row.saturated;
        sum.outside += row.outside;
    }
    printf("%.6f %.17g %.17g %.17g %.17g %.17g\n", (double)(clock() - began) / CLOCKS_PER_SEC, sum.e_mr,
           sum.e_rms, sum.drive, sum.saturated, sum.outside);
    return 0;
}
