/* Ticks of one FMU against those of another build of it: two shared libraries, called by the same code.
 *
 *     bench_before AFTER.so GUID RESOURCES BEFORE.so GUID RESOURCES INPUT OUTPUT LOW HIGH
 *
 * RESOURCES is the URI of a folder with the parameters.ssv of the GUID. INPUT and OUTPUT are value references,
 * those of both builds joined by a colon; the input goes from LOW to HIGH and back. Prints nanoseconds after, nanoseconds before and the median of their ratio, for a tick and for a tick with a
 * directional derivative. benchmarks/before.py runs it. */
#include "bench.h"

#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

#define SAMPLES 256
#define SAMPLE_TIME 1e-4

struct build {
    fmi2Component instance;
    fmi2SetRealTYPE *set_real;
    fmi2GetRealTYPE *get_real;
    fmi2DoStepTYPE *do_step;
    fmi2GetDirectionalDerivativeTYPE *derivative;
    fmi2ValueReference input, output;
    long ticks;
};

static struct build after, before;
static double input[SAMPLES];
static volatile double sink; /* keeps results alive */

static void fail(const char *what, const char *which)
{
    fprintf(stderr, "bench_before: %s: %s\n", which, what);
    exit(2);
}

/* Copies the address of a function: ISO C has no cast from an object's. */
#define FIND(handle, member, name) \
    do { \
        void *address = dlsym(handle, name); \
        if (!address) \
            fail("missing", name); \
        memcpy(&(member), &address, sizeof address); \
    } while (0)

static void begin(struct build *build, void *handle)
{
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *leave;

    FIND(handle, setup, "fmi2SetupExperiment");
    FIND(handle, enter, "fmi2EnterInitializationMode");
    FIND(handle, leave, "fmi2ExitInitializationMode");
    if (setup(build->instance, fmi2False, 0.0, 0.0, fmi2False, 0.0) > fmi2Warning ||
        enter(build->instance) > fmi2Warning || leave(build->instance) > fmi2Warning)
        fail("the settings are refused", "fmi2ExitInitializationMode");
}

static void open_build(struct build *build, char *argument[])
{
    static const fmi2CallbackFunctions callbacks = { NULL, NULL, NULL, NULL, NULL };
    fmi2InstantiateTYPE *instantiate;
    void *handle = dlopen(argument[0], RTLD_NOW | RTLD_LOCAL);

    if (!handle)
        fail(dlerror(), argument[0]);
    FIND(handle, instantiate, "fmi2Instantiate");
    FIND(handle, build->set_real, "fmi2SetReal");
    FIND(handle, build->get_real, "fmi2GetReal");
    FIND(handle, build->do_step, "fmi2DoStep");
    FIND(handle, build->derivative, "fmi2GetDirectionalDerivative");
    build->instance =
        instantiate("bench", fmi2CoSimulation, argument[1], argument[2], &callbacks, fmi2False, fmi2False);
    if (!build->instance)
        fail("no instance", argument[0]);
    begin(build, handle);
}

static inline double tick(struct build *b)
{
    double y;

    b->set_real(b->instance, &b->input, 1, &input[b->ticks % SAMPLES]);
    if (b->do_step(b->instance, (double)b->ticks * SAMPLE_TIME, SAMPLE_TIME, fmi2True) > fmi2Warning)
        fail("a step is refused", "fmi2DoStep");
    b->ticks++;
    b->get_real(b->instance, &b->output, 1, &y);
    return y;
}

static void ticks(struct build *b, long count)
{
    for (long k = 0; k < count; k++)
        sink = tick(b);
}

static void derivatives(struct build *b, long count)
{
    const double seed = 1.0;
    double d = 0.0;

    for (long k = 0; k < count; k++) {
        sink = tick(b);
        b->derivative(b->instance, &b->output, 1, &b->input, 1, &seed, &d);
        sink = d;
    }
}

static void ticks_after(long count)
{
    ticks(&after, count);
}

static void ticks_before(long count)
{
    ticks(&before, count);
}

static void derivatives_after(long count)
{
    derivatives(&after, count);
}

static void derivatives_before(long count)
{
    derivatives(&before, count);
}

static void row(const char *what, work *a, work *b)
{
    const struct comparison c = compare(a, b);

    printf("%s %.1f %.1f %.3f\n", what, c.a, c.b, c.ratio);
}

int main(int count, char **argument)
{
    if (count != 11 || sscanf(argument[7], "%u:%u", &after.input, &before.input) != 2 ||
        sscanf(argument[8], "%u:%u", &after.output, &before.output) != 2)
        fail("ten arguments are needed", "usage");
    open_build(&after, argument + 1);
    open_build(&before, argument + 4);
    const double low = strtod(argument[9], NULL), high = strtod(argument[10], NULL);
    for (int k = 0; k < SAMPLES; k++)
        input[k] = 0.5 * (low + high) - 0.5 * (high - low) * cos(6.283185307179586 * k / SAMPLES);
    row("tick", ticks_after, ticks_before);
    row("derivative", derivatives_after, derivatives_before);
    return 0;
}
