/* PIController: a sampled PI controller with feedforward as an FMI 2.0 slave. It closes the loop around
 * IT2Inverse and IT2Plant in studies of feedback, and knows nothing of them.
 *
 * At every tick, with e = reference - displacement:
 *
 *     integral += integralGain * sampleTime * e
 *     voltage = feedforward + proportionalGain * e + integral, within voltageMin..voltageMax
 *
 * While the limit holds, the integral does not grow further into it. Ticks are counted by the code that
 * counts those of IT2Plant (fmu_clock.h). The variables are those of python/it2hys/controller.toml, by
 * their place in it. */
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "fmu_clock.h"

#define GUID "{b1f0c6de-2d0e-4f53-9c39-7c5f4b4f2d01}"

enum real {
    REFERENCE, DISPLACEMENT, FEEDFORWARD, VOLTAGE,
    SAMPLE_TIME, PROPORTIONAL_GAIN, INTEGRAL_GAIN, VOLTAGE_MIN, VOLTAGE_MAX, INITIAL_VOLTAGE,
    REALS,
    LIMITED = REALS /* the one Boolean */
};

enum phase {
    INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, TERMINATED = 8,
    ANY_PHASE = INSTANTIATED | INITIALIZATION | STEPPING | TERMINATED
};

/* All that an FMU state holds: a plain value without pointers or padding. */
struct state {
    double real[REALS];
    double integral;
    struct fmu_clock clock;
    int32_t phase;
    int32_t limited;
};

struct controller {
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char *name;
    bool events, errors; /* log categories */
    struct state now;
};

static void begin(struct controller *c)
{
    static const double START[REALS] = {
        [SAMPLE_TIME] = 1e-4, [VOLTAGE_MAX] = 150.0,
    };

    c->now = (struct state){ .phase = INSTANTIATED, .clock.stop_time = INFINITY };
    memcpy(c->now.real, START, sizeof START);
}

/* Errors are told even where logging is off. The logger takes a printf format, but not every host looks
 * at its arguments: the text goes into the format, its percent signs doubled. */
static fmi2Status say(const struct controller *c, fmi2Status status, const char *format, ...)
{
    char text[512], escaped[2 * sizeof text];
    va_list arguments;
    size_t n = 0;

    if (!c->logger || !(status == fmi2OK ? c->events : c->errors))
        return status;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (const char *from = text; *from; from++) {
        if (*from == '%')
            escaped[n++] = '%';
        escaped[n++] = *from;
    }
    escaped[n] = '\0';
    c->logger(c->environment, c->name, status, status == fmi2OK ? "logEvents" : "logStatusError",
              escaped);
    return status;
}

static bool may(const struct controller *c, const char *function, int phases)
{
    if (!c)
        return false;
    if (c->now.phase & phases)
        return true;
    say(c, fmi2Error, "%s: not allowed now.", function);
    return false;
}

static fmi2Status check(const struct controller *c, const double *p, const char *function)
{
    if (!(p[SAMPLE_TIME] >= 1e-9 && p[SAMPLE_TIME] <= 1e3))
        return say(c, fmi2Error, "%s: sampleTime is %g s; it must be 1e-9 to 1000 s.", function,
                   p[SAMPLE_TIME]);
    if (!(p[VOLTAGE_MIN] < p[VOLTAGE_MAX]))
        return say(c, fmi2Error, "%s: voltageMin, %g V, must be below voltageMax, %g V.", function,
                   p[VOLTAGE_MIN], p[VOLTAGE_MAX]);
    return fmi2OK;
}

/* Without fmin and fmax, which would be all that this FMU needs of libm. */
static double within(double voltage, const double *p)
{
    return voltage < p[VOLTAGE_MIN] ? p[VOLTAGE_MIN] : voltage > p[VOLTAGE_MAX] ? p[VOLTAGE_MAX] : voltage;
}

/* Outputs before the first tick, and whether the parameters can be used. */
static fmi2Status start(struct controller *c, const char *function)
{
    double *p = c->now.real;

    if (check(c, p, function) != fmi2OK)
        return fmi2Error;
    c->now.integral = p[INITIAL_VOLTAGE];
    p[VOLTAGE] = within(p[INITIAL_VOLTAGE], p);
    return fmi2OK;
}

static void tick(struct state *c)
{
    double *p = c->real;
    const double error = p[REFERENCE] - p[DISPLACEMENT];
    const double integral = c->integral + p[INTEGRAL_GAIN] * p[SAMPLE_TIME] * error;
    const double wanted = p[FEEDFORWARD] + p[PROPORTIONAL_GAIN] * error + integral;
    const double given = within(wanted, p);
    const bool deeper = (wanted > given && integral > c->integral) ||
                        (wanted < given && integral < c->integral);

    c->limited = given != wanted;
    if (!deeper)
        c->integral = integral;
    p[VOLTAGE] = given;
}

/* --- FMI 2.0 ----------------------------------------------------------------------------------- */

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return "2.0";
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    static const char function[] = "fmi2SetDebugLogging";
    struct controller *controller = c;
    bool events = n == 0, errors = n == 0;

    if (!may(controller, function, ANY_PHASE))
        return fmi2Error;
    for (size_t i = 0; i < n; i++) {
        const char *name = categories && categories[i] ? categories[i] : "a null pointer";
        if (strcmp(name, "logEvents") == 0)
            events = true;
        else if (strcmp(name, "logStatusError") == 0)
            errors = true;
        else
            return say(controller, fmi2Error, "%s: %s is no log category.", function, name);
    }
    controller->events = events ? on : controller->events;
    controller->errors = errors ? on : controller->errors;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    struct controller early = { .name = (char *)"", .events = logging, .errors = true };

    (void)resources, (void)visible;
    if (functions) {
        early.logger = functions->logger;
        early.environment = functions->componentEnvironment;
    }
    if (!name || !*name || type != fmi2CoSimulation || !guid || strcmp(guid, GUID) != 0) {
        say(&early, fmi2Error, "fmi2Instantiate: needs a name, co-simulation and the GUID " GUID ".");
        return NULL;
    }
    const size_t size = strlen(name) + 1;
    struct controller *c = malloc(sizeof *c);
    early.name = malloc(size);
    if (!c || !early.name) {
        free(c);
        free(early.name);
        return NULL;
    }
    memcpy(early.name, name, size);
    *c = early;
    begin(c);
    return c;
}

void fmi2FreeInstance(fmi2Component c)
{
    if (c)
        free(((struct controller *)c)->name);
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start_time, fmi2Boolean stop_time_defined, fmi2Real stop_time)
{
    static const char function[] = "fmi2SetupExperiment";
    struct controller *controller = c;
    struct fmu_clock clock = { 0 };
    char text[128];

    (void)tolerance_defined, (void)tolerance;
    if (!may(c, function, INSTANTIATED))
        return fmi2Error;
    if (!fmu_clock_setup(&clock, start_time, stop_time_defined, stop_time, text, sizeof text))
        return say(c, fmi2Error, "%s: %s.", function, text);
    controller->now.clock = clock;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    if (!may(c, "fmi2EnterInitializationMode", INSTANTIATED))
        return fmi2Error;
    ((struct controller *)c)->now.phase = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    static const char function[] = "fmi2ExitInitializationMode";
    struct controller *controller = c;

    if (!may(c, function, INITIALIZATION) || start(c, function) != fmi2OK)
        return fmi2Error;
    fmu_clock_start(&controller->now.clock, controller->now.real[SAMPLE_TIME]);
    controller->now.phase = STEPPING;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    if (!may(c, "fmi2Terminate", STEPPING))
        return fmi2Error;
    ((struct controller *)c)->now.phase = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    if (!may(c, "fmi2Reset", ANY_PHASE))
        return fmi2Error;
    begin(c);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    struct controller *controller = c;

    if (!may(c, "fmi2GetReal", INITIALIZATION | STEPPING | TERMINATED))
        return fmi2Error;
    if (controller->now.phase == INITIALIZATION && start(c, "fmi2GetReal") != fmi2OK)
        return fmi2Error;
    if (n && (!vr || !value))
        return say(c, fmi2Error, "fmi2GetReal: an array is a null pointer.");
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= REALS)
            return say(c, fmi2Error, "fmi2GetReal: no Real variable has the value reference %u.",
                       vr[i]);
        value[i] = controller->now.real[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[])
{
    if (!may(c, "fmi2GetBoolean", INITIALIZATION | STEPPING | TERMINATED))
        return fmi2Error;
    if (n && (!vr || !value))
        return say(c, fmi2Error, "fmi2GetBoolean: an array is a null pointer.");
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != LIMITED)
            return say(c, fmi2Error, "fmi2GetBoolean: no Boolean variable has the value reference %u.",
                       vr[i]);
        value[i] = ((struct controller *)c)->now.limited;
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    struct controller *controller = c;

    if (!may(c, "fmi2SetReal", INSTANTIATED | INITIALIZATION | STEPPING))
        return fmi2Error;
    if (n && (!vr || !value))
        return say(c, fmi2Error, "fmi2SetReal: an array is a null pointer.");
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= REALS || vr[i] == VOLTAGE)
            return say(c, fmi2Error, "fmi2SetReal: no variable that can be set has the value reference "
                       "%u.", vr[i]);
        if (vr[i] > VOLTAGE && controller->now.phase == STEPPING)
            return say(c, fmi2Error, "fmi2SetReal: parameters are fixed; set them before "
                       "fmi2ExitInitializationMode.");
        if (!isfinite(value[i]))
            return say(c, fmi2Discard, "fmi2SetReal: a value must be a finite number, not %g.",
                       value[i]);
    }
    for (size_t i = 0; i < n; i++)
        controller->now.real[vr[i]] = value[i];
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_rollback)
{
    struct controller *controller = c;
    struct fmu_clock end;
    char text[256];

    (void)no_rollback;
    if (!may(c, "fmi2DoStep", STEPPING))
        return fmi2Error;
    struct state *now = &controller->now;
    const double sample_time = now->real[SAMPLE_TIME];
    if (!fmu_clock_step(&now->clock, sample_time, time, step, &end))
        return say(c, fmi2Error, "fmi2DoStep: %s.",
                   fmu_clock_refusal(&now->clock, sample_time, time, step, text, sizeof text));
    const double integral = now->integral, voltage = now->real[VOLTAGE];
    const int32_t limited = now->limited;
    /* the inputs are held through the step, so every tick of it sees the same error */
    for (int64_t k = now->clock.next_tick; k < end.next_tick; k++)
        tick(now);
    if (!isfinite(now->integral)) {
        now->integral = integral, now->real[VOLTAGE] = voltage, now->limited = limited;
        return say(c, fmi2Discard, "fmi2DoStep: the integral is no longer finite between %g s and "
                   "%g s; the step is not made.", time, end.time);
    }
    now->clock = end;
    return fmi2OK;
}

/* --- the FMU state ----------------------------------------------------------------------------- */

/* What precedes the state where it is serialized. */
struct header {
    char magic[8];
    uint64_t order; /* tells byte orders apart */
    uint64_t size;
    uint64_t checksum;
};

enum { BLOB = sizeof(struct header) + sizeof(struct state) };

static struct header header_of(const struct state *state)
{
    struct header header = { "PICtrl2", 0x0102030405060708u, sizeof *state, 14695981039346656037u };
    const unsigned char *byte = (const unsigned char *)state;

    for (size_t i = 0; i < sizeof *state; i++) /* FNV-1a */
        header.checksum = (header.checksum ^ byte[i]) * 1099511628211u;
    return header;
}

/* A checksum stops damage, not invention: what a step relies on is checked too. */
static bool plausible(const struct controller *c, const struct state *s, const char *function)
{
    bool finite = isfinite(s->integral) && isfinite(s->clock.time) && s->clock.stop_time > -INFINITY;

    for (int i = 0; i < REALS; i++)
        finite = finite && isfinite(s->real[i]);
    if (!finite || (s->limited != 0 && s->limited != 1))
        return false;
    if (s->phase == STEPPING || s->phase == TERMINATED)
        return check(c, s->real, function) == fmi2OK && fmu_clock_plausible(&s->clock, s->real[SAMPLE_TIME]);
    return s->phase == INSTANTIATED || s->phase == INITIALIZATION;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    if (!may(c, "fmi2GetFMUstate", ANY_PHASE))
        return fmi2Error;
    if (!state)
        return say(c, fmi2Error, "fmi2GetFMUstate: a null pointer.");
    if (!*state)
        *state = malloc(sizeof(struct state));
    if (!*state)
        return say(c, fmi2Error, "fmi2GetFMUstate: out of memory.");
    memcpy(*state, &((struct controller *)c)->now, sizeof(struct state));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    if (!may(c, "fmi2SetFMUstate", ANY_PHASE))
        return fmi2Error;
    if (!state)
        return say(c, fmi2Error, "fmi2SetFMUstate: a null pointer.");
    memcpy(&((struct controller *)c)->now, state, sizeof(struct state));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    if (!may(c, "fmi2FreeFMUstate", ANY_PHASE))
        return fmi2Error;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    if (!may(c, "fmi2SerializedFMUstateSize", ANY_PHASE))
        return fmi2Error;
    if (!state || !size)
        return say(c, fmi2Error, "fmi2SerializedFMUstateSize: a null pointer.");
    *size = BLOB;
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    if (!may(c, "fmi2SerializeFMUstate", ANY_PHASE))
        return fmi2Error;
    if (!state || !bytes || size < BLOB)
        return say(c, fmi2Error, "fmi2SerializeFMUstate: needs a state and room for %d bytes.", BLOB);
    const struct header header = header_of(state);
    memcpy(bytes, &header, sizeof header);
    memcpy(bytes + sizeof header, state, sizeof(struct state));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state)
{
    static const char function[] = "fmi2DeSerializeFMUstate";
    struct state read = { .phase = 0 };

    if (!may(c, function, ANY_PHASE))
        return fmi2Error;
    if (!bytes || !state)
        return say(c, fmi2Error, "%s: a null pointer.", function);
    if (size == BLOB)
        memcpy(&read, bytes + sizeof(struct header), sizeof read);
    const struct header header = header_of(&read);
    if (size != BLOB || memcmp(&header, bytes, sizeof header) != 0 || !plausible(c, &read, function))
        return say(c, fmi2Error, "%s: these bytes are damaged or not a state of PIController.",
                   function);
    *state = malloc(sizeof read); /* never read before: masters pass it uninitialised */
    if (!*state)
        return say(c, fmi2Error, "%s: out of memory.", function);
    memcpy(*state, &read, sizeof read);
    return fmi2OK;
}

/* --- what a controller of ten numbers has no use for -------------------------------------------- */

static fmi2Status lacking(fmi2Component c, const char *function)
{
    return c ? say(c, fmi2Error, "%s: not supported, as the model description says.", function)
             : fmi2Error;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : lacking(c, "fmi2GetInteger");
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : lacking(c, "fmi2GetString");
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          const fmi2Integer value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : lacking(c, "fmi2SetInteger");
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          const fmi2Boolean value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : lacking(c, "fmi2SetBoolean");
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                         const fmi2String value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : lacking(c, "fmi2SetString");
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[],
                                        size_t unknown_count, const fmi2ValueReference knowns[],
                                        size_t known_count, const fmi2Real seeds[], fmi2Real values[])
{
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seeds, (void)values;
    return lacking(c, "fmi2GetDirectionalDerivative");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr, (void)n, (void)order, (void)value;
    return lacking(c, "fmi2SetRealInputDerivatives");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)n, (void)order, (void)value;
    return lacking(c, "fmi2GetRealOutputDerivatives");
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    return lacking(c, "fmi2CancelStep");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    return lacking(c, "fmi2GetStatus");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    if (!c || kind != fmi2LastSuccessfulTime || !value)
        return lacking(c, "fmi2GetRealStatus");
    *value = ((struct controller *)c)->now.clock.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    return lacking(c, "fmi2GetIntegerStatus");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    (void)kind, (void)value;
    return lacking(c, "fmi2GetBooleanStatus");
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind, (void)value;
    return lacking(c, "fmi2GetStringStatus");
}
