/* A byte string as a sequence of FMI calls on two PIControllers, with any arguments in any order. After
 * each call:
 *   - the status is one that the function may return;
 *   - a refused call left the instance as it was;
 *   - what it holds and hands out is finite;
 *   - going back to a state and stepping again gives the same bits, here and in the other instance. */

#include "controller.h"
#include "fmi2Functions.h"
#include "fuzz_host.h"

#define GUID "{b1f0c6de-2d0e-4f53-9c39-7c5f4b4f2d01}"

/* Value references, and the first that is a parameter's. */
enum { VOLTAGE = 3, PROPORTIONAL_GAIN = 5, INTEGRAL_GAIN = 6 };

/* All that an FMU state of the controller holds. */
struct block {
    struct fmu_snapshot s;
    struct pi_parameters parameter;
    double integral;
    double last_integral;
};

/* Where it begins in a serialized state, and its checksum. */
enum { HEADER = 40, CHECKSUM = 32, BLOB = HEADER + sizeof(struct block) };

enum { INSTANCES = 2, CALLS = 48, ARRAY = 4, TICKS = 1000 };

static fmi2Component instances[INSTANCES];
static struct block begun[INSTANCES]; /* where most sequences begin */
static fmi2Byte blob[BLOB];
static fmi2FMUstate slot;

static struct block *inside(fmi2Component c)
{
    fmu_gather(c);
    return (struct block *)(void *)((struct fmu *)c)->now;
}

/* --- the host ------------------------------------------------------------------------------------ */

static void open_instances(void)
{
    for (int i = 0; i < INSTANCES; i++) {
        instances[i] = fmi2Instantiate("fuzz", fmi2CoSimulation, GUID, NULL, &HOST, fmi2False, fmi2True);
        FUZZ_PROMISE(instances[i]);
        const fmi2ValueReference gains[] = { PROPORTIONAL_GAIN, INTEGRAL_GAIN };
        const double values[] = { 2e6, 1e9 };
        FUZZ_PROMISE(fmi2SetReal(instances[i], gains, 2, values) == fmi2OK);
        if (i == 0) /* the other one begins before its initialization */
            FUZZ_PROMISE(fmi2EnterInitializationMode(instances[i]) == fmi2OK &&
                         fmi2ExitInitializationMode(instances[i]) == fmi2OK);
        begun[i] = *inside(instances[i]);
    }
}

/* --- arguments ----------------------------------------------------------------------------------- */

struct arrays {
    size_t count;
    fmi2ValueReference reference[ARRAY];
    double real[ARRAY];
    const fmi2ValueReference *references; /* or NULL */
    double *reals;
};

static void arrays(struct fuzz_bytes *in, struct arrays *a)
{
    const unsigned shape = fuzz_byte(in);

    a->count = shape < 192 ? 1 : shape % (ARRAY + 1);
    for (size_t i = 0; i < a->count; i++) {
        a->reference[i] = fuzz_byte(in) % 14;
        a->real[i] = fuzz_number(in);
    }
    a->references = shape >= 253 ? NULL : a->reference;
    a->reals = shape >= 250 && shape < 253 ? NULL : a->real;
}

/* None that is possible has more than TICKS ticks. */
static double step_size(fmi2Component c, struct fuzz_bytes *in)
{
    static const double SPECIAL[] = { 0.0, NAN, INFINITY, -1.0, 1e300, 5e-324 };
    const unsigned kind = fuzz_byte(in);

    if (kind < 6)
        return SPECIAL[kind];
    return inside(c)->parameter.sampleTime * (kind < 16 ? fuzz_short(in) % TICKS : fuzz_byte(in) / 16.0);
}

/* --- calls --------------------------------------------------------------------------------------- */

static void call_lifecycle(fmi2Component c, struct fuzz_bytes *in, fmi2Status *status)
{
    const double start = fuzz_number(in);

    switch (fuzz_byte(in) % 6) {
    case 0: *status = fmi2SetupExperiment(c, fmi2False, 0.0, start, fmi2False, 0.0); break;
    case 1: *status = fmi2EnterInitializationMode(c); break;
    case 2: *status = fmi2ExitInitializationMode(c); break;
    case 3: *status = fmi2Terminate(c); break;
    case 4: *status = fmi2CancelStep(c); break;
    default: *status = fmi2Reset(c);
    }
}

static void call_set(fmi2Component c, struct fuzz_bytes *in, fmi2Status *status)
{
    struct arrays a;

    arrays(in, &a);
    *status = fmi2SetReal(c, a.references, a.count, a.reals);
}

static void call_get(fmi2Component c, struct fuzz_bytes *in, fmi2Status *status)
{
    const unsigned which = fuzz_byte(in);
    int limited[ARRAY];
    struct arrays a;

    arrays(in, &a);
    if (which < 192)
        *status = fmi2GetReal(c, a.references, a.count, a.reals);
    else
        *status = fmi2GetBoolean(c, a.references, a.count, a.reals ? limited : NULL);
}

static void call_step(fmi2Component c, struct fuzz_bytes *in, fmi2Status *status)
{
    const unsigned kind = fuzz_byte(in);
    const double time = kind < 240 ? inside(c)->s.clock.time : fuzz_number(in);

    *status = fmi2DoStep(c, time, step_size(c, in), fmi2False);
}

static void call_state(fmi2Component c, struct fuzz_bytes *in, fmi2Status *status)
{
    const unsigned which = fuzz_byte(in);
    size_t size = 0;

    if (which < 128) {
        FUZZ_PROMISE(fmi2GetFMUstate(c, &slot) == fmi2OK);
        FUZZ_PROMISE(fmi2SerializedFMUstateSize(c, slot, &size) == fmi2OK && size == BLOB);
        *status = fmi2SerializeFMUstate(c, slot, blob, which < 100 ? BLOB : which % BLOB);
    } else
        *status = fmi2SetFMUstate(c, slot); /* which may be NULL */
}

/* Bytes that claim to be a state: as serialized, damaged, or damaged under a checksum that is right. */
static void call_deserialize(fmi2Component c, struct fuzz_bytes *in, fmi2Status *status)
{
    const unsigned which = fuzz_byte(in);
    fmi2FMUstate state = NULL;

    for (unsigned i = 0; i < which % 4; i++) {
        const double value = fuzz_number(in);
        memcpy(blob + HEADER + fuzz_byte(in) % (sizeof(struct block) / 8) * 8, &value, sizeof value);
    }
    const uint64_t checksum = fmu_hash(blob + HEADER, sizeof(struct block));
    if (which & 128)
        memcpy(blob + CHECKSUM, &checksum, sizeof checksum);
    *status = fmi2DeSerializeFMUstate(c, blob, which & 64 ? which % BLOB : BLOB, &state);
    if (*status != fmi2OK)
        return;
    FUZZ_PROMISE(fmi2FreeFMUstate(c, &slot) == fmi2OK);
    slot = state;
}

static void call_rollback(fmi2Component c, struct fuzz_bytes *in, fmi2Status *status)
{
    fmi2Component other = instances[c == instances[0]];
    struct block own = *inside(other);
    const struct fuzz_bytes same = *in;
    fmi2FMUstate state = NULL;
    fmi2Status again = fmi2OK;

    FUZZ_PROMISE(fmi2GetFMUstate(c, &state) == fmi2OK);
    call_step(c, in, status);
    const struct block first = *inside(c);
    for (int i = 0; i < INSTANCES; i++) {
        struct fuzz_bytes repeated = same;
        FUZZ_PROMISE(fmi2SetFMUstate(instances[i], state) == fmi2OK);
        call_step(instances[i], &repeated, &again);
        FUZZ_PROMISE(again == *status && memcmp(&first, inside(instances[i]), sizeof first) == 0);
    }
    FUZZ_PROMISE(fmi2SetFMUstate(other, &own) == fmi2OK);
    FUZZ_PROMISE(fmi2FreeFMUstate(c, &state) == fmi2OK);
}

/* What the description denies. */
static void call_lacking(fmi2Component c, struct fuzz_bytes *in, fmi2Status *status)
{
    const fmi2ValueReference reference = fuzz_byte(in);
    const fmi2Integer order = 1;
    double value = fuzz_number(in);

    FUZZ_PROMISE(fmi2SetRealInputDerivatives(c, &reference, 1, &order, &value) == fmi2Error);
    FUZZ_PROMISE(fmi2GetRealOutputDerivatives(c, &reference, 1, &order, &value) == fmi2Error);
    *status = fmi2GetDirectionalDerivative(c, &reference, 1, &reference, 1, &value, &value);
    FUZZ_PROMISE(*status == fmi2Error);
}

static void call_logging(fmi2Component c, struct fuzz_bytes *in, fmi2Status *status)
{
    static const fmi2String NAMES[] = { "logEvents", "logStatusError", "%n", "", NULL };
    const unsigned which = fuzz_byte(in);

    *status = fmi2SetDebugLogging(c, which & 1, which & 2 ? 1 : 0, &NAMES[fuzz_byte(in) % 5]);
}

typedef void call(fmi2Component, struct fuzz_bytes *, fmi2Status *);

static call *const CALL[] = { call_step,    call_step,      call_set,         call_set,
                              call_get,     call_state,     call_deserialize, call_rollback,
                              call_lacking, call_lifecycle, call_logging };

/* --- promises ------------------------------------------------------------------------------------ */

static void all_is_finite(fmi2Component c)
{
    const fmi2ValueReference reference = VOLTAGE;
    double voltage;

    if (fmi2GetReal(c, &reference, 1, &voltage) == fmi2OK) /* computed now in initialization */
        FUZZ_PROMISE(isfinite(voltage));
    const struct pi_parameters *p = &inside(c)->parameter;
    const double *parameter = &p->sampleTime;
    for (size_t i = 0; i < sizeof *p / sizeof *parameter; i++)
        FUZZ_PROMISE(isfinite(parameter[i]));
    for (int i = 0; i < FMU_INPUTS; i++)
        FUZZ_PROMISE(isfinite(inside(c)->s.input[i]));
    FUZZ_PROMISE(isfinite(inside(c)->integral) && isfinite(inside(c)->s.clock.time));
}

/* Some begin with gains that overflow in different directions. */
static void begin_sequence(struct fuzz_bytes *in)
{
    for (int i = 0; i < INSTANCES; i++)
        FUZZ_PROMISE(fmi2SetFMUstate(instances[i], &begun[i]) == fmi2OK);
    if (fuzz_byte(in) < 32) {
        inside(instances[0])->parameter.proportionalGain = -1e300;
        inside(instances[0])->parameter.integralGain = 1e300;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_bytes in = { data, data + size };

    if (!instances[0])
        open_instances();
    begin_sequence(&in);
    for (int n = 0; n < CALLS && in.next < in.end; n++) {
        fmi2Component c = instances[fuzz_byte(&in) % INSTANCES];
        struct block before;
        fmi2Status status = fmi2OK;
        all_is_finite(c);
        before = *inside(c);
        CALL[fuzz_byte(&in) % (sizeof CALL / sizeof CALL[0])](c, &in, &status);
        FUZZ_PROMISE(status == fmi2OK || status == fmi2Discard || status == fmi2Error);
        if (status == fmi2Discard)
            before.s.last_status = inside(c)->s.last_status; /* what fmi2GetStatus is asked for */
        if (status != fmi2OK)
            FUZZ_PROMISE(memcmp(&before, inside(c), sizeof before) == 0);
        all_is_finite(c);
    }
    FUZZ_PROMISE(fmi2FreeFMUstate(instances[0], &slot) == fmi2OK);
    return 0;
}
