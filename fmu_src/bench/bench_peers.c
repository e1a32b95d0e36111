/* Nanoseconds per tick of the plant FMU against those of other FMUs, all of them shared libraries called by
 * the same code.
 *
 *   bench_peers PLANT.so STANDIN.so
 *
 * The environment variable REFERENCE_FMUS names folders, separated by colons, with the unpacked FMUs
 * Dahlquist and VanDerPol of modelica/Reference-FMUs, built elsewhere: with this project's flags, as
 * CMAKE_BUILD_TYPE=Release and CMAKE_C_FLAGS_RELEASE=-O2 do, and, to see what their own build makes of them,
 * without a build type, which means without optimisation. Without the variable, a model without physics
 * behind this project's own FMI layer stands in.
 *
 * Each is stepped by its DefaultExperiment's step, which is one step of the peers' fixed-step solver and one
 * tick of the plant, and by a hundred of them per doStep. What cannot be undercut is in the table too: the
 * core's step without FMI, and FMI without physics. */
#include "bench.h"

#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "chain.h"
#include "fmi2FunctionTypes.h"
#include "fmu_start.h"
#include "fmu_table_hash.h"

struct peer {
    const char *name;
    fmi2Component component;
    fmi2SetRealTYPE *set;
    fmi2GetRealTYPE *get;
    fmi2DoStepTYPE *step;
    fmi2SetFMUstateTYPE *set_state;
    fmi2FMUstate beginning;
    fmi2ValueReference input, output;
    bool has_input;
    double step_size;
};

/* The ports of the plant's FMI layer: voltage and displacement. */
#define PLANT_PORTS .input = 0, .output = 4, .has_input = true

static struct peer plant = { .name = "IT2Plant", PLANT_PORTS };
static struct peer standin = { .name = "stand-in", PLANT_PORTS };
static struct peer other;
static long ticks_per_step = 1;
static volatile double sink; /* keeps results alive */

/* Back to the beginning every so often: Dahlquist's x decays to numbers too small to be normal, which
 * are slow, and a long time no longer is a multiple of the step. */
enum { TICKS_PER_RUN = 1000, LONG_STEP = CHUNK_MULTIPLE };

static void run(struct peer *p, long ticks)
{
    const double step_size = (double)ticks_per_step * p->step_size;
    double value = 50.0;
    long refused = 0;

    for (long k = 0; k < ticks; k += ticks_per_step) {
        const int n = (int)(k % TICKS_PER_RUN);
        if (n == 0)
            p->set_state(p->component, p->beginning);
        if (p->has_input)
            p->set(p->component, &p->input, 1, &value);
        refused += p->step(p->component, n * p->step_size, step_size, fmi2True) > fmi2Warning;
        p->get(p->component, &p->output, 1, &value);
        value = 50.0 + (double)(k & 31);
    }
    if (refused) {
        fprintf(stderr, "bench_peers: %s refuses %ld steps\n", p->name, refused);
        exit(1);
    }
}

static void run_plant(long ticks)
{
    run(&plant, ticks);
}

static void run_standin(long ticks)
{
    run(&standin, ticks);
}

static void run_other(long ticks)
{
    run(&other, ticks);
}

/* The same inputs to the core alone. */
static void run_core(long ticks)
{
    static struct it2 core;
    struct it2_state state;

    it2_prepare(&core, FMU_START.rule, FMU_START.ruleCount,
                (struct it2_range){ FMU_START.displacementMin, FMU_START.displacementMax });
    it2_reset(&state, FMU_START.initialDisplacement);
    for (long k = 0; k < ticks; k++)
        it2_step(&core, &state, 50.0 + (double)(k & 31));
    sink = state.y;
}

static void drop(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                 fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)instance, (void)status, (void)category, (void)message;
}

/* A function of a library; C has no cast from an object's address to a function's. */
static void find(void *library, const char *name, void *function)
{
    void *symbol = dlsym(library, name);

    if (!symbol) {
        fprintf(stderr, "bench_peers: no %s: %s\n", name, dlerror());
        exit(1);
    }
    memcpy(function, &symbol, sizeof symbol);
}

static bool open_peer(struct peer *p, const char *path, const char *guid, double step_size)
{
    static const fmi2CallbackFunctions host = { drop, calloc, free, NULL, NULL };
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    fmi2InstantiateTYPE *instantiate;
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter, *leave;
    fmi2GetFMUstateTYPE *get_state;

    if (!library)
        return false;
    find(library, "fmi2Instantiate", &instantiate);
    find(library, "fmi2SetupExperiment", &setup);
    find(library, "fmi2EnterInitializationMode", &enter);
    find(library, "fmi2ExitInitializationMode", &leave);
    find(library, "fmi2SetReal", &p->set);
    find(library, "fmi2GetReal", &p->get);
    find(library, "fmi2DoStep", &p->step);
    find(library, "fmi2GetFMUstate", &get_state);
    find(library, "fmi2SetFMUstate", &p->set_state);
    p->component = instantiate("bench", fmi2CoSimulation, guid, NULL, &host, fmi2False, fmi2False);
    p->step_size = step_size;
    return p->component && setup(p->component, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK &&
           enter(p->component) == fmi2OK && leave(p->component) == fmi2OK &&
           get_state(p->component, &p->beginning) == fmi2OK;
}

/* The text of an attribute in an unpacked FMU's modelDescription.xml. */
static bool attribute(const char *folder, const char *name, char *value, size_t size)
{
    static char text[1 << 16];
    char path[1024], key[64];

    snprintf(path, sizeof path, "%s/modelDescription.xml", folder);
    FILE *file = fopen(path, "rb");
    if (!file)
        return false;
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    snprintf(key, sizeof key, " %s=\"", name);
    const char *begin = strstr(text, key);
    if (begin)
        snprintf(value, size, "%.*s", (int)strcspn(begin + strlen(key), "\""), begin + strlen(key));
    return begin != NULL;
}

static bool open_reference(const char *folder, const char *name)
{
    char home[768], path[1024], guid[64], step[64];

    snprintf(home, sizeof home, "%s/%s", folder, name);
    snprintf(path, sizeof path, "%s/binaries/linux64/%s.so", home, name);
    other = (struct peer){ .name = name, .output = 1 };
    return attribute(home, "guid", guid, sizeof guid) && attribute(home, "stepSize", step, sizeof step) &&
           open_peer(&other, path, guid, strtod(step, NULL));
}

static double row(const char *name, work *a, long ticks)
{
    ticks_per_step = ticks;
    const struct comparison c = compare(a, run_other);

    printf("%-14s %-10s %10ld %8.1f %8.1f %8.2f\n", name, other.name, ticks, c.a, c.b, c.ratio);
    fflush(stdout);
    return c.ratio;
}

static void against_reference_fmus(const char *folder)
{
    static const char *const names[] = { "Dahlquist", "VanDerPol" };
    double worst = 0.0;

    printf("\nReference-FMUs in %s\n", folder);
    for (int i = 0; i < 2; i++) {
        if (!open_reference(folder, names[i])) {
            printf("%s: no usable FMU there\n", names[i]);
            continue;
        }
        const double ratio = row(plant.name, run_plant, 1);
        worst = ratio > worst ? ratio : worst;
        row(plant.name, run_plant, LONG_STEP);
        row("core alone", run_core, 1);
        row("FMI alone", run_standin, 1);
    }
    if (worst > 0.0)
        printf("IT2Plant against the faster one: %.2f (target: at most 0.70 where the flags are the same)\n",
               worst);
}

int main(int count, char **argument)
{
    const char *folders = getenv("REFERENCE_FMUS");
    char guid[64], list[4096];

    if (count < 3)
        return 2;
    snprintf(guid, sizeof guid, "{%016llx%016llx}", (unsigned long long)FMU_TABLE_HASH_PLANT,
             (unsigned long long)FMU_START_HASH);
    if (!open_peer(&plant, argument[1], guid, FMU_START.sampleTime) ||
        !open_peer(&standin, argument[2], guid, FMU_START.sampleTime))
        return 1;
    printf(
        "\nA tick of an FMU, by its DefaultExperiment's step: nanoseconds of A and B, median of A/B.\n"
        "A and B: fmi2SetReal (without an input: not) + DoStep of so many ticks + GetReal, per tick.\n"
        "core alone: it2_step without FMI. FMI alone: this project's FMI layer around a model without physics.\n"
        "\n%-14s %-10s %10s %8s %8s %8s\n",
        "A", "B", "ticks/step", "A ns", "B ns", "A/B");
    if (folders && *folders) {
        snprintf(list, sizeof list, "%s", folders);
        for (char *folder = strtok(list, ":"); folder; folder = strtok(NULL, ":"))
            against_reference_fmus(folder);
        return 0;
    }
    other = standin;
    row(plant.name, run_plant, 1);
    puts(
        "REFERENCE_FMUS is not set: no peer was measured. The stand-in is FMI alone, so that A/B tells what the\n"
        "plant adds to the layer.");
    return 0;
}
