/* A byte string as a sequence of FMI calls on two plants and an inverse, with any arguments in any
 * order. After each call:
 *   - the status is one that the function may return;
 *   - a refused call left the instance as it was;
 *   - outputs that are handed out are finite;
 *   - going back to a state and stepping again gives the same bits, here and in another instance. */

#include "fmi2_api.h"
#include "fmu_start.h"
#include "fuzz_host.h"

enum {
    INSTANCES = 3, /* the first two are plants and may exchange states */
    SLOTS = 4,     /* FMU states kept, per model */
    CALLS = 48,    /* of one sequence */
    ARRAY = 4,     /* longest array of arguments */
    TICKS = 1000,  /* longest step */
    PHASES = 4,
    BLOB = 8192
};

enum allowed { OK_ERROR = 1, OK_DISCARD_ERROR = 2, STEP = 3, VALUES = 4 };

struct subject {
    const struct fmi2_api *api;
    fmi2Component c;
    fmi2FMUstate *slot;         /* of its model */
    fmi2FMUstate phase[PHASES]; /* where sequences begin */
    struct block before;        /* of the call under test */
};

static struct subject subjects[INSTANCES];
static fmi2FMUstate slots[2][SLOTS];
static fmi2Byte blob[BLOB];
static size_t blob_size;

/* --- the host ------------------------------------------------------------------------------------ */

static fmi2Component instantiate(const struct fmi2_api *api, const char *name, bool logging)
{
    char guid[64];

    snprintf(guid, sizeof guid, "{%016llx%016llx}", (unsigned long long)api->table_hash,
             (unsigned long long)FMU_START_HASH);
    return api->Instantiate(name, fmi2CoSimulation, guid, NULL, &HOST, fmi2False, logging);
}

static struct block *inside(const struct subject *s)
{
    return block_of(s->c);
}

static void save_phases(struct subject *s)
{
    const struct fmi2_api *m = s->api;

    m->GetFMUstate(s->c, &s->phase[0]);
    m->EnterInitializationMode(s->c);
    m->GetFMUstate(s->c, &s->phase[1]);
    m->ExitInitializationMode(s->c);
    m->GetFMUstate(s->c, &s->phase[2]);
    m->Terminate(s->c);
    m->GetFMUstate(s->c, &s->phase[3]);
}

static void open_subjects(void)
{
    for (int i = 0; i < INSTANCES; i++) {
        struct subject *s = &subjects[i];
        s->api = i < 2 ? &PLANT : &INVERSE;
        s->slot = slots[i < 2 ? 0 : 1];
        s->c = instantiate(s->api, "fuzz", false);
        FUZZ_PROMISE(s->c);
        save_phases(s);
    }
}

/* Most sequences begin with running instances: checking a parameter set takes longer than all else. */
static void begin(struct fuzz_bytes *in)
{
    const unsigned where = fuzz_byte(in);
    const int phase = where < 192 ? 2 : (int)(where % PHASES);

    for (int i = 0; i < INSTANCES; i++) {
        struct subject *s = &subjects[i];
        FUZZ_PROMISE(s->api->SetFMUstate(s->c, s->phase[phase]) == fmi2OK);
        FUZZ_PROMISE(s->api->SetDebugLogging(s->c, fmi2False, 0, NULL) == fmi2OK);
    }
    blob_size = 0;
}

static void end(void)
{
    for (int i = 0; i < INSTANCES; i++)
        for (int k = 0; k < SLOTS; k++)
            FUZZ_PROMISE(subjects[i].api->FreeFMUstate(subjects[i].c, &subjects[i].slot[k]) == fmi2OK);
}

/* --- arguments ----------------------------------------------------------------------------------- */

struct arrays {
    size_t count;
    fmi2ValueReference reference[ARRAY];
    const fmi2ValueReference *references; /* or NULL */
    double real[ARRAY];
    int integer[ARRAY];
    bool null;
};

static void arrays(struct fuzz_bytes *in, struct arrays *a)
{
    const unsigned shape = fuzz_byte(in);

    a->count = shape < 192 ? 1 : shape % (ARRAY + 1);
    a->null = shape >= 250;
    for (size_t i = 0; i < a->count; i++) {
        a->reference[i] = fuzz_reference(in, 16, FMU_TABLE_ROWS);
        a->real[i] = fuzz_number(in);
        a->integer[i] = (int)fuzz_byte(in) - 2;
    }
    a->references = shape >= 253 ? NULL : a->reference;
}

/* Half of all numbers are ordinary steps; none that is possible has more than TICKS ticks. */
static double step_size(struct fuzz_bytes *in, double sample_time)
{
    static const double SPECIAL[] = { 0.0, -0.0, NAN, INFINITY, -INFINITY, -1.0, 1e300, 5e-324, -5e-324 };
    const unsigned kind = fuzz_byte(in);

    if (kind < 9)
        return SPECIAL[kind];
    if (kind < 16)
        return sample_time * (fuzz_short(in) % TICKS);
    if (kind < 64)
        return sample_time * fuzz_byte(in) / 16.0;
    return sample_time;
}

static double step_time(struct fuzz_bytes *in, double now)
{
    const unsigned kind = fuzz_byte(in);

    if (kind < 232)
        return now;
    return kind < 240 ? now * (1.0 + DBL_EPSILON * (kind - 236.0)) : fuzz_number(in);
}

/* --- promises ------------------------------------------------------------------------------------ */

static bool refused(fmi2Status status)
{
    return status == fmi2Discard || status == fmi2Error;
}

static void outputs_are_finite(const struct subject *s)
{
    static const fmi2ValueReference of_plant[] = { 4, 5 }, of_inverse[] = { 6 };
    const bool plant = s->api->kind == FMU_PLANT;
    double value[2] = { 0.0, 0.0 };

    if (s->api->GetReal(s->c, plant ? of_plant : of_inverse, plant ? 2 : 1, value) == fmi2OK)
        FUZZ_PROMISE(isfinite(value[0]) && isfinite(value[1]));
}

/* In initialization outputs are computed when they are asked for: ask now, so that nothing moves. */
static void watch(struct subject *s)
{
    if (inside(s)->s.phase == FMU_INITIALIZATION)
        outputs_are_finite(s);
    s->before = *inside(s);
}

static void check(struct subject *s, fmi2Status status, enum allowed allowed)
{
    FUZZ_PROMISE(status == fmi2OK || status == fmi2Error || (status == fmi2Discard && allowed != OK_ERROR) ||
                 (status == fmi2Warning && allowed == STEP));
    if (refused(status)) {
        if (allowed == STEP && status == fmi2Discard)
            s->before.s.last_status = fmi2Discard; /* what fmi2GetStatus is asked for */
        FUZZ_PROMISE(memcmp(&s->before, inside(s), sizeof s->before) == 0);
    } else
        outputs_are_finite(s);
}

/* --- calls --------------------------------------------------------------------------------------- */

static void call_lifecycle(struct subject *s, struct fuzz_bytes *in)
{
    const struct fmi2_api *m = s->api;
    const unsigned which = fuzz_byte(in);

    switch (which % 8) {
    case 0:
    case 1: {
        const double start = fuzz_number(in), stop = fuzz_number(in), tolerance = fuzz_number(in);
        check(s, m->SetupExperiment(s->c, which & 16, tolerance, start, which & 32, stop), OK_ERROR);
        break;
    }
    case 2:
    case 3: check(s, m->EnterInitializationMode(s->c), OK_ERROR); break;
    case 4:
    case 5: check(s, m->ExitInitializationMode(s->c), OK_ERROR); break;
    case 6: check(s, m->Terminate(s->c), OK_ERROR); break;
    default: check(s, m->Reset(s->c), OK_ERROR);
    }
}

static void call_get(struct subject *s, struct fuzz_bytes *in)
{
    const struct fmi2_api *m = s->api;
    double values[ARRAY];
    int integers[ARRAY];
    fmi2String strings[ARRAY];
    struct arrays a;
    const unsigned which = fuzz_byte(in);

    arrays(in, &a);
    if (which < 160)
        check(s, m->GetReal(s->c, a.references, a.count, a.null ? NULL : values), OK_ERROR);
    else if (which < 192)
        check(s, m->GetInteger(s->c, a.references, a.count, a.null ? NULL : integers), OK_ERROR);
    else if (which < 224)
        check(s, m->GetBoolean(s->c, a.references, a.count, a.null ? NULL : integers), OK_ERROR);
    else if (which < 240)
        check(s, m->GetString(s->c, a.references, a.count, a.null ? NULL : strings), OK_ERROR);
    else
        check(s, m->GetRealOutputDerivatives(s->c, a.references, a.count, a.integer, values), OK_ERROR);
}

static void call_set(struct subject *s, struct fuzz_bytes *in)
{
    const struct fmi2_api *m = s->api;
    fmi2String strings[ARRAY] = { "", "a", NULL, "%s" };
    struct arrays a;
    const unsigned which = fuzz_byte(in);

    arrays(in, &a);
    const double *reals = a.null ? NULL : a.real;
    const int *integers = a.null ? NULL : a.integer;
    if (which < 144)
        check(s, m->SetReal(s->c, a.references, a.count, reals), VALUES);
    else if (which < 192)
        check(s, m->SetRealInputDerivatives(s->c, a.references, a.count, integers, reals), VALUES);
    else if (which < 232)
        check(s, m->SetInteger(s->c, a.references, a.count, integers), VALUES);
    else if (which < 244)
        check(s, m->SetBoolean(s->c, a.references, a.count, integers), VALUES);
    else
        check(s, m->SetString(s->c, a.references, a.count, strings), VALUES);
}

static void call_step(struct subject *s, struct fuzz_bytes *in)
{
    const double time = step_time(in, inside(s)->s.clock.time);
    const double step = step_size(in, inside(s)->parameter.sampleTime);

    check(s, s->api->DoStep(s->c, time, step, fmi2True), STEP);
}

/* Input, slope and step, as masters do. */
static void call_ordinary_step(struct subject *s, struct fuzz_bytes *in)
{
    const bool plant = s->api->kind == FMU_PLANT;
    const fmi2ValueReference input = plant ? 0 : 1;
    const fmi2Integer order = 1;
    const double value = fuzz_byte(in) * (plant ? 0.5 : 7e-8);
    const double slope = ((int)fuzz_byte(in) - 128) * (plant ? 10.0 : 1e-6);

    check(s, s->api->SetReal(s->c, &input, 1, &value), VALUES);
    watch(s);
    check(s, s->api->SetRealInputDerivatives(s->c, &input, 1, &order, &slope), VALUES);
    watch(s);
    call_step(s, in);
}

static void call_status(struct subject *s, struct fuzz_bytes *in)
{
    const struct fmi2_api *m = s->api;
    const unsigned which = fuzz_byte(in);
    const fmi2StatusKind kind = (fmi2StatusKind)(fuzz_byte(in) % 5);
    const bool null = which >= 250;
    fmi2Status status;
    double real;
    int integer;
    fmi2String string;

    switch (which % 6) {
    case 0: check(s, m->GetStatus(s->c, kind, null ? NULL : &status), OK_DISCARD_ERROR); break;
    case 1: check(s, m->GetRealStatus(s->c, kind, null ? NULL : &real), OK_DISCARD_ERROR); break;
    case 2: check(s, m->GetIntegerStatus(s->c, kind, null ? NULL : &integer), OK_DISCARD_ERROR); break;
    case 3: check(s, m->GetBooleanStatus(s->c, kind, null ? NULL : &integer), OK_DISCARD_ERROR); break;
    case 4: check(s, m->GetStringStatus(s->c, kind, null ? NULL : &string), OK_DISCARD_ERROR); break;
    default: check(s, m->CancelStep(s->c), OK_ERROR);
    }
}

static void call_logging(struct subject *s, struct fuzz_bytes *in)
{
    static const fmi2String NAMES[] = { "logAll", "logEvents", "logStatusError", "%n", "", NULL };
    const unsigned which = fuzz_byte(in);
    fmi2String categories[ARRAY];
    const size_t count = which % (ARRAY + 1);

    for (size_t i = 0; i < count; i++)
        categories[i] = NAMES[fuzz_byte(in) % 6];
    check(s, s->api->SetDebugLogging(s->c, which & 128, count, which & 64 ? NULL : categories), OK_ERROR);
}

/* Derivatives of finite seeds that are handed out are finite. */
static void call_derivative(struct subject *s, struct fuzz_bytes *in)
{
    struct arrays of, by;
    double values[ARRAY] = { 0.0 };

    arrays(in, &of);
    arrays(in, &by);
    const fmi2Status status =
        s->api->GetDirectionalDerivative(s->c, of.references, of.count, by.references, by.count,
                                         by.null ? NULL : by.real, of.null ? NULL : values);
    check(s, status, OK_DISCARD_ERROR);
    for (size_t i = 0; i < of.count && status == fmi2OK; i++)
        FUZZ_PROMISE(isfinite(values[i]));
}

static void call_state(struct subject *s, struct fuzz_bytes *in)
{
    const struct fmi2_api *m = s->api;
    const unsigned which = fuzz_byte(in);
    fmi2FMUstate *slot = &s->slot[which / 8 % SLOTS];
    size_t size = 0;

    switch (which % 8) {
    case 0:
    case 1: check(s, m->GetFMUstate(s->c, which < 250 ? slot : NULL), OK_ERROR); break;
    case 2: check(s, m->SetFMUstate(s->c, *slot), OK_ERROR); break;
    case 3: check(s, m->FreeFMUstate(s->c, which < 250 ? slot : NULL), OK_ERROR); break;
    case 4: check(s, m->SerializedFMUstateSize(s->c, *slot, which < 250 ? &size : NULL), OK_ERROR); break;
    default:
        m->SerializedFMUstateSize(s->c, *slot, &size);
        FUZZ_PROMISE(size <= BLOB);
        if (which >= 128)
            size = fuzz_short(in) % BLOB;
        if (m->SerializeFMUstate(s->c, *slot, which < 250 ? blob : NULL, size) == fmi2OK)
            blob_size = size;
    }
}

/* Where the snapshot begins in a serialized state, and its checksum. */
enum { HEADER = 40, CHECKSUM = 32 };

/* Bytes that claim to be a state: as serialized, damaged, or damaged under a checksum that is right. */
static void call_deserialize(struct subject *s, struct fuzz_bytes *in)
{
    const unsigned which = fuzz_byte(in);
    size_t size = which & 64 ? blob_size + fuzz_byte(in) % 3 - 1 : blob_size;
    fmi2FMUstate state = NULL;

    if (size > BLOB)
        size = 0;
    for (unsigned i = 0; i < which % 4 && blob_size; i++) {
        const size_t at = fuzz_short(in) % (blob_size - 8);
        if (which & 4) { /* a whole number, in its place */
            const double value = fuzz_number(in);
            memcpy(blob + at / 8 * 8, &value, sizeof value);
        } else
            blob[at] ^= (fmi2Byte)fuzz_byte(in);
    }
    if (which & 128 && blob_size > HEADER) {
        const uint64_t checksum = fmu_hash(blob + HEADER, blob_size - HEADER);
        memcpy(blob + CHECKSUM, &checksum, sizeof checksum);
    }
    const fmi2Status status = s->api->DeSerializeFMUstate(s->c, which < 250 ? blob : NULL, size, &state);
    check(s, status, OK_ERROR);
    if (status != fmi2OK)
        return;
    FUZZ_PROMISE(s->api->FreeFMUstate(s->c, &s->slot[which / 8 % SLOTS]) == fmi2OK);
    s->slot[which / 8 % SLOTS] = state;
}

/* Back to a state and the same step: the same bits, in this instance and in another one of its model. */
static void call_rollback(struct subject *s, struct fuzz_bytes *in)
{
    struct subject *other = s->api == &PLANT ? &subjects[s == subjects] : s;
    const struct fuzz_bytes same = *in;
    struct fuzz_bytes again = same;
    struct block first;
    fmi2FMUstate state = NULL, of_other = NULL;

    FUZZ_PROMISE(s->api->GetFMUstate(s->c, &state) == fmi2OK);
    FUZZ_PROMISE(s->api->GetFMUstate(other->c, &of_other) == fmi2OK);
    call_ordinary_step(s, in);
    first = *inside(s);
    FUZZ_PROMISE(s->api->SetFMUstate(s->c, state) == fmi2OK);
    watch(s);
    call_ordinary_step(s, &again);
    FUZZ_PROMISE(memcmp(&first, inside(s), sizeof first) == 0);
    again = same;
    FUZZ_PROMISE(s->api->SetFMUstate(other->c, state) == fmi2OK);
    watch(other);
    call_ordinary_step(other, &again);
    FUZZ_PROMISE(memcmp(&first, inside(other), sizeof first) == 0);
    if (other != s)
        FUZZ_PROMISE(s->api->SetFMUstate(other->c, of_other) == fmi2OK);
    s->api->FreeFMUstate(s->c, &state);
    s->api->FreeFMUstate(s->c, &of_other);
}

/* Instances that come and go, and ones that are refused. */
static void call_instantiate(struct subject *s, struct fuzz_bytes *in)
{
    static const char *const NAMES[] = { "x", "", NULL, "%s%n" };
    const unsigned which = fuzz_byte(in);
    char guid[64];
    fmi2Component c;

    if (which < 128)
        c = instantiate(s->api, NAMES[which % 4], which & 8);
    else {
        fuzz_take(in, guid, sizeof guid - 1);
        guid[sizeof guid - 1] = '\0';
        c = s->api->Instantiate("x", which & 1 ? fmi2CoSimulation : fmi2ModelExchange, guid, "no/such",
                                which & 2 ? &HOST : NULL, fmi2False, fmi2False);
        FUZZ_PROMISE(!c);
    }
    s->api->FreeInstance(c);
}

/* Without an instance. */
static void call_null(struct subject *s, struct fuzz_bytes *in)
{
    const struct fmi2_api *m = s->api;
    fmi2FMUstate state = NULL;

    (void)in;
    FUZZ_PROMISE(m->SetupExperiment(NULL, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2Error);
    FUZZ_PROMISE(m->DoStep(NULL, 0.0, 1.0, fmi2True) == fmi2Error);
    FUZZ_PROMISE(m->Reset(NULL) == fmi2Error && m->Terminate(NULL) == fmi2Error);
    FUZZ_PROMISE(m->GetFMUstate(NULL, &state) == fmi2Error && m->SetFMUstate(NULL, NULL) == fmi2Error);
    FUZZ_PROMISE(m->GetReal(NULL, NULL, 0, NULL) == fmi2Error && m->CancelStep(NULL) == fmi2Error);
    m->FreeInstance(NULL);
}

typedef void call(struct subject *, struct fuzz_bytes *);

static call *const CALL[] = {
    call_ordinary_step, call_ordinary_step, call_step,   call_step,        call_set,         call_set,
    call_get,           call_state,         call_state,  call_deserialize, call_rollback,    call_derivative,
    call_lifecycle,     call_lifecycle,     call_status, call_logging,     call_instantiate, call_null,
};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_bytes in = { data, data + size };

    if (!subjects[0].c)
        open_subjects();
    begin(&in);
    for (int n = 0; n < CALLS && in.next < in.end; n++) {
        struct subject *s = &subjects[fuzz_byte(&in) % INSTANCES];
        watch(s);
        CALL[fuzz_byte(&in) % (sizeof CALL / sizeof CALL[0])](s, &in);
    }
    end();
    return 0;
}
