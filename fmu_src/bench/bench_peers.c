/* What a tick costs, against what others cost and what it must not cost more than: in one run, each row's two
 * things in turn, medians of the ratios of neighbours (bench.h).
 *
 *   bench_peers PLANT.so INVERSE.so LAYER.so [NAME PEER.so FMI2.xml]...
 *
 * Peers are FMUs of modelica/Reference-FMUs, built from their published sources by the same compiler with the
 * same flags (CMakeLists.txt, REFERENCE_FMUS); without them their rows are left out. LAYER.so is a model without
 * physics behind this project's FMI layer.
 *
 * A tick is fmi2SetReal, where there is an input, fmi2DoStep and fmi2GetReal, with the step of the
 * DefaultExperiment: one step of a peer's fixed-step solver, one tick of plant and inverse. */
#include "bench.h"

#include <dlfcn.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "bench_it2.h"
#include "fmi2FunctionTypes.h"
#include "fmu_table_hash.h"

/* Back to the beginning every so often: Dahlquist's x decays to numbers too small to be normal, which
 * are slow, and a long time no longer is a multiple of the step. */
enum { TICKS_PER_RUN = 1000, LONG_STEP = CHUNK_MULTIPLE };

/* An FMU, and what it is given: a sine from `low` to `high`. */
struct subject {
    const char *name;
    fmi2Component component;
    fmi2SetRealTYPE *set;
    fmi2GetRealTYPE *get;
    fmi2DoStepTYPE *step;
    fmi2SetFMUstateTYPE *set_state;
    fmi2FMUstate beginning;
    fmi2ValueReference input, output;
    bool has_input;
    double step_size, low, high;
    double value[TICKS_PER_RUN];
};

/* Voltage and displacement; reference and voltage. */
#define PLANT_PORTS .input = 0, .output = 4, .has_input = true, .low = 30.0, .high = 70.0
#define INVERSE_PORTS .input = 1, .output = 6, .has_input = true, .low = 5e-6, .high = 9e-6

enum { MAX_PEERS = 4 };
static struct subject plant = { .name = "IT2Plant", PLANT_PORTS };
static struct subject inverse = { .name = "IT2Inverse", INVERSE_PORTS };
static struct subject layer = { .name = "layer alone", PLANT_PORTS };
static struct subject peers[MAX_PEERS];
static int peer_count;
static double wave[SAMPLES]; /* from 0 to 1 and back */

/* --- ticks --------------------------------------------------------------------------------------- */

/* What is measured, and what against. */
static struct subject *measured, *other;
static int ticks_per_step;

/* Returns how many steps are refused. */
static long run_once(struct subject *s, int ticks, int per_step)
{
    const double step_size = per_step * s->step_size;
    double value = 0.0;
    long refused = 0;

    s->set_state(s->component, s->beginning);
    for (int n = 0; n < ticks; n += per_step) {
        if (s->has_input)
            s->set(s->component, &s->input, 1, &s->value[n]);
        refused += s->step(s->component, n * s->step_size, step_size, fmi2True) > fmi2Warning;
        s->get(s->component, &s->output, 1, &value);
    }
    sink = value;
    return refused;
}

static void run(struct subject *s, long ticks, int per_step)
{
    long refused = 0;

    for (long k = 0; k < ticks; k += TICKS_PER_RUN)
        refused += run_once(s, ticks - k < TICKS_PER_RUN ? (int)(ticks - k) : TICKS_PER_RUN, per_step);
    if (refused) {
        fprintf(stderr, "bench_peers: %s refuses %ld steps\n", s->name, refused);
        exit(1);
    }
}

static void run_measured(long ticks)
{
    run(measured, ticks, ticks_per_step);
}

static void run_other(long ticks)
{
    run(other, ticks, 1);
}

/* --- the core alone ------------------------------------------------------------------------------ */

static void choose_rules(int count)
{
    static struct it2_table table;

    prepare_core(count);
    it2_tabulate(&core, &table);
    for (int k = 0; k < SAMPLES; k++) {
        voltage[k] = 20.0 + 80.0 * wave[k];
        displacement[k] = 2e-6 + 12e-6 * wave[k];
    }
}

/* Rounds of six exponentials, the arguments of each following from the round before. */
static void six_exponentials(long rounds)
{
    double y = 0.5;

    for (long k = 0; k < rounds; k++) {
        double sum = 0.0;
        for (int i = 0; i < 6; i++)
            sum += exp(-0.25 * i - 1.8 - y);
        y = sum;
    }
    sink = y;
}

/* --- FMUs ---------------------------------------------------------------------------------------- */

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

static void begin(struct subject *s, void *library)
{
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter, *leave;
    fmi2GetFMUstateTYPE *get_state;

    find(library, "fmi2SetupExperiment", &setup);
    find(library, "fmi2EnterInitializationMode", &enter);
    find(library, "fmi2ExitInitializationMode", &leave);
    find(library, "fmi2SetReal", &s->set);
    find(library, "fmi2GetReal", &s->get);
    find(library, "fmi2DoStep", &s->step);
    find(library, "fmi2GetFMUstate", &get_state);
    find(library, "fmi2SetFMUstate", &s->set_state);
    if (setup(s->component, fmi2False, 0.0, 0.0, fmi2False, 0.0) != fmi2OK || enter(s->component) != fmi2OK ||
        leave(s->component) != fmi2OK || get_state(s->component, &s->beginning) != fmi2OK) {
        fprintf(stderr, "bench_peers: %s cannot be initialized\n", s->name);
        exit(1);
    }
}

static void open_subject(struct subject *s, const char *path, const char *guid, double step_size)
{
    static const fmi2CallbackFunctions host = { drop, calloc, free, NULL, NULL };
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    fmi2InstantiateTYPE *instantiate;

    if (!library) {
        fprintf(stderr, "bench_peers: %s\n", dlerror());
        exit(1);
    }
    find(library, "fmi2Instantiate", &instantiate);
    s->component = instantiate("bench", fmi2CoSimulation, guid, NULL, &host, fmi2False, fmi2False);
    s->step_size = step_size;
    for (int n = 0; n < TICKS_PER_RUN; n++)
        s->value[n] = s->low + (s->high - s->low) * wave[n % SAMPLES];
    begin(s, library);
}

static void open_own(struct subject *s, const char *path, unsigned long long table_hash)
{
    char guid[64];

    snprintf(guid, sizeof guid, "{%016llx%016llx}", table_hash, (unsigned long long)FMU_START_HASH);
    open_subject(s, path, guid, FMU_START.sampleTime);
}

/* The text of an attribute in a model description. */
static void attribute(const char *path, const char *name, char *value, size_t size)
{
    static char text[1 << 16];
    char key[64];
    FILE *file = fopen(path, "rb");

    text[file ? fread(text, 1, sizeof text - 1, file) : 0] = '\0';
    if (file)
        fclose(file);
    snprintf(key, sizeof key, " %s=\"", name);
    const char *begin = strstr(text, key);
    if (!begin) {
        fprintf(stderr, "bench_peers: %s has no %s\n", path, name);
        exit(1);
    }
    snprintf(value, size, "%.*s", (int)strcspn(begin + strlen(key), "\""), begin + strlen(key));
}

/* x of each peer is its value reference 1. */
static void open_peer(const char *name, const char *path, const char *description)
{
    char guid[64], step[64];

    attribute(description, "guid", guid, sizeof guid);
    attribute(description, "stepSize", step, sizeof step);
    peers[peer_count] = (struct subject){ .name = name, .output = 1 };
    open_subject(&peers[peer_count++], path, guid, strtod(step, NULL));
}

/* --- all effects --------------------------------------------------------------------------------- */

static fmi2Status set(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    return (fmi2Status)fmu_set_real(c, "set", vr, n, value);
}

static fmi2Status get(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    return (fmi2Status)fmu_get_real(c, "get", vr, n, value);
}

static fmi2Status step(fmi2Component c, fmi2Real time, fmi2Real length, fmi2Boolean never_back)
{
    (void)never_back;
    return (fmi2Status)fmu_do_step(c, "step", time, length);
}

static fmi2Status set_state(fmi2Component c, fmi2FMUstate state)
{
    return (fmi2Status)fmu_set_state(c, "set_state", state);
}

/* As benchmarks/before.py has them. */
static struct chain_parameters all_effects(void)
{
    struct chain_parameters p = FMU_START;

    p.initialDisplacement = 5e-6;
    p.lag.timeConstant = 3e-4;
    p.playCount = 2;
    p.play[0] = (struct play_element){ 2.0, 0.1 };
    p.play[1] = (struct play_element){ 6.0, -0.05 };
    p.creepCount = 2;
    p.creep[0] = (struct creep_element){ 0.02, 0.1 };
    p.creep[1] = (struct creep_element){ 0.02, 10.0 };
    p.resonance = (resonance_parameters){ 900.0, 0.05, -0.25, 5e-5 };
    p.slew.rate = 1e6;
    p.saturation = (saturation_parameters){ -50.0, 200.0 };
    p.delay.time = 5e-4;
    p.load.compliance = 2e-8;
    p.drift = (drift_parameters){ 1e-8, 1e-12 };
    p.nonlinearity.quadratic = 2e-7;
    p.nonlinearity.cubic = 1e-7;
    p.nonlinearity.maximum = 1.6e-5;
    p.hum.amplitude = 2e-8;
    p.hum.frequency = 50.0;
    return p;
}

/* More play operators than Table 1 has are in no FMU that is built here: so without the functions of FMI 2.0, which
 * only translate. */
static struct subject with_effects(struct subject s, const struct fmu_model *model)
{
    static const struct fmu_host silent = { .log = NULL };
    const struct chain_parameters p = all_effects();
    struct fmu *fmu = fmu_create(model, "bench", &p, &silent, false);
    void *state = NULL;

    if (!fmu || fmu_setup(fmu, "setup", false, 0.0, 0.0, false, 0.0) != FMU_OK ||
        fmu_enter_initialization(fmu, "enter") != FMU_OK || fmu_exit_initialization(fmu, "exit") != FMU_OK ||
        fmu_get_state(fmu, "get", &state) != FMU_OK) {
        fprintf(stderr, "bench_peers: %s with all effects is refused\n", s.name);
        exit(1);
    }
    s.component = fmu, s.beginning = state, s.step_size = p.sampleTime;
    s.set = set, s.get = get, s.step = step, s.set_state = set_state;
    return s;
}

/* --- the table ----------------------------------------------------------------------------------- */

static const char *verdict(double value, double target)
{
    return target <= 0.0 ? "" : value <= target ? "met" : "missed";
}

static void print(const char *name, int per_step, const char *against, struct comparison c, double target)
{
    printf("%-22s %10d %8.1f   %-16s %8.1f %8.2f", name, per_step, c.a, against, c.b, c.ratio);
    if (target > 0.0)
        printf("   <= %-5.2f %s", target, verdict(c.ratio, target));
    putchar('\n');
    fflush(stdout);
}

/* Against each peer's tick; the target is of the faster. */
static void against_peers(struct subject *s, int per_step, double target)
{
    measured = s, ticks_per_step = per_step;
    for (int i = 0; i < peer_count; i++) {
        other = &peers[i];
        print(s->name, per_step, peers[i].name, compare(run_measured, run_other), target);
    }
}

static void core_row(int rules, const char *name, work *a)
{
    char text[64];

    choose_rules(rules);
    snprintf(text, sizeof text, "%s, %d rules", name, rules);
    print(text, 1, "six libm exp", compare(a, six_exponentials), 0.5);
}

/* In nanoseconds; beside it the plant, to see how fast the machine is now. */
static void nanoseconds(struct subject *s, const char *name, double target)
{
    measured = s, ticks_per_step = 1, other = &plant;
    const struct comparison c = compare(run_measured, run_other);

    printf("%-22s %10d %8.1f   %-16s %8.1f %8.2f   <= %g ns %s\n", name, 1, c.a, plant.name, c.b, c.ratio,
           target, verdict(c.a, target));
    fflush(stdout);
}

int main(int count, char **argument)
{
    for (int k = 0; k < SAMPLES; k++)
        wave[k] = 0.5 - 0.5 * cos(6.283185307179586 * k / SAMPLES);
    if (count < 4 || (count - 4) % 3 != 0 || count > 4 + 3 * MAX_PEERS)
        return 2;
    open_own(&plant, argument[1], FMU_TABLE_HASH_PLANT);
    open_own(&inverse, argument[2], FMU_TABLE_HASH_INVERSE);
    open_own(&layer, argument[3], FMU_TABLE_HASH_PLANT);
    for (int i = 4; i < count; i += 3)
        open_peer(argument[i], argument[i + 1], argument[i + 2]);
    static struct subject plant_with_all, inverse_with_all;
    plant_with_all = with_effects(plant, &plant_model);
    inverse_with_all = with_effects(inverse, &inverse_model);

    printf("\nA tick: nanoseconds of A, per tick, and of B, median of A/B, and the target.\n\n"
           "%-22s %10s %8s   %-16s %8s %8s   target\n",
           "A", "ticks/step", "A ns", "B", "B ns", "A/B");
    against_peers(&plant, 1, 1.0);
    against_peers(&plant, LONG_STEP, 0.7);
    against_peers(&inverse, 1, 1.2);
    against_peers(&inverse, LONG_STEP, 0.5);
    core_row(3, "core", core_steps);
    core_row(16, "core", core_steps);
    core_row(3, "its inverse", core_inverses);
    core_row(16, "its inverse", core_inverses);
    nanoseconds(&layer, "layer alone", 9.0);
    nanoseconds(&plant_with_all, "plant, all effects", 60.0);
    nanoseconds(&inverse_with_all, "inverse, all effects", 80.0);
    if (peer_count == 0)
        puts(
            "Rows against other FMUs are left out: REFERENCE_FMUS names no sources of modelica/Reference-FMUs.");
    return 0;
}
