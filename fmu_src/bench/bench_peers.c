/* Nanoseconds per tick of the plant FMU against those of other FMUs, all of them shared libraries built
 * with the same flags and called by the same code.
 *
 *   bench_peers PLANT.so STANDIN.so
 *
 * The environment variable REFERENCE_FMUS names a folder with the unpacked FMUs Dahlquist and VanDerPol
 * of modelica/Reference-FMUs, built elsewhere. Without it, a model without physics behind this
 * project's own FMI layer stands in. Each is stepped by its DefaultExperiment's step. */
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

static struct peer plant = { .name = "IT2Plant", .input = 0, .output = 4, .has_input = true };
static struct peer other;

/* Back to the beginning every so often: Dahlquist's x decays to numbers too small to be normal, which
 * are slow, and a long time no longer is a multiple of the step. */
enum { STEPS_PER_RUN = 1000 };

static void run(struct peer *p, long steps)
{
    double value = 50.0;
    long refused = 0;

    for (long k = 0; k < steps; k++) {
        const int n = (int)(k % STEPS_PER_RUN);
        if (n == 0)
            p->set_state(p->component, p->beginning);
        if (p->has_input)
            p->set(p->component, &p->input, 1, &value);
        refused += p->step(p->component, n * p->step_size, p->step_size, fmi2True) > fmi2Warning;
        p->get(p->component, &p->output, 1, &value);
        value = 50.0 + (double)(k & 31);
    }
    if (refused) {
        fprintf(stderr, "bench_peers: %s refuses %ld of %ld steps\n", p->name, refused, steps);
        exit(1);
    }
}

static void run_plant(long steps)
{
    run(&plant, steps);
}

static void run_other(long steps)
{
    run(&other, steps);
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

static double row(void)
{
    const struct comparison c = compare(run_plant, run_other);

    printf("%-10s %-10s %10.1f %10.1f %8.2f\n", plant.name, other.name, c.a, c.b, c.ratio);
    fflush(stdout);
    return c.ratio;
}

static void against_reference_fmus(const char *folder)
{
    static const char *const names[] = { "Dahlquist", "VanDerPol" };
    double worst = 0.0;

    for (int i = 0; i < 2; i++) {
        if (!open_reference(folder, names[i])) {
            printf("%s: no usable FMU in %s\n", names[i], folder);
            continue;
        }
        const double ratio = row();
        worst = ratio > worst ? ratio : worst;
    }
    printf("against the faster one: %.2f (target: at most 0.70)\n", worst);
}

int main(int count, char **argument)
{
    const char *folder = getenv("REFERENCE_FMUS");
    char guid[64];

    if (count < 3)
        return 2;
    snprintf(guid, sizeof guid, "{%016llx%016llx}", (unsigned long long)FMU_TABLE_HASH_PLANT,
             (unsigned long long)FMU_START_HASH);
    if (!open_peer(&plant, argument[1], guid, FMU_START.sampleTime))
        return 1;
    printf("\nA tick of an FMU, by its DefaultExperiment's step: nanoseconds of A and B, median of A/B.\n"
           "A: fmi2SetReal + DoStep + GetReal; B: the same, without an input where B has none.\n\n"
           "%-10s %-10s %10s %10s %8s\n", "A", "B", "A ns", "B ns", "A/B");
    if (folder && *folder) {
        against_reference_fmus(folder);
        return 0;
    }
    other = (struct peer){ .name = "stand-in", .input = 0, .output = 4, .has_input = true };
    if (!open_peer(&other, argument[2], guid, FMU_START.sampleTime))
        return 1;
    row();
    puts("REFERENCE_FMUS is not set: no peer was measured. The stand-in is this project's FMI layer around a\n"
         "model without physics, so that A/B tells what the plant adds to the layer.");
    return 0;
}
