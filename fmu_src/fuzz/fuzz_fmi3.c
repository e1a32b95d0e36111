/* A byte string as a sequence of calls of FMI 3.0 on two plants and an inverse, with any arguments in any order:
 * arrays of any length, sizes that change, and hosts that make calls while a step asks them for inputs. After each
 * call:
 *   - the status is one that the function may return;
 *   - a refused call left the instance as it was;
 *   - outputs that are handed out are finite;
 *   - going back to a state and stepping again gives the same bits. */

#include "fmi2_api.h" /* struct block */
#include "fmi3_api.h"
#include "fmu_start.h"
#include "fuzz.h"
#include "play.h"

enum {
    INSTANCES = 3,
    SLOTS = 3,   /* FMU states kept, per model */
    CALLS = 48,  /* of one sequence */
    ARRAY = 40,  /* longest array of arguments */
    TICKS = 200, /* longest step */
    PHASES = 5,
    BLOB = 8192
};

enum allowed { OK_ERROR = 1, OK_DISCARD_ERROR = 2, STEP = 3 };

struct subject {
    const struct fmi3_api *api;
    fmi3Instance c;
    fmi3FMUState *slot;         /* of its model */
    fmi3FMUState phase[PHASES]; /* where sequences begin */
    struct block before;        /* of the call under test */
    double last_update;         /* within a step */
    double step_end;
};

static struct subject subjects[INSTANCES];
static fmi3FMUState slots[2][SLOTS];
static fmi3Byte blob[BLOB];
static size_t blob_size;
static struct fuzz_bytes *bytes; /* of the sequence, for what the host does within steps */

/* --- the host ------------------------------------------------------------------------------------ */

static void log_message(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                        fmi3String message)
{
    (void)environment;
    FUZZ_PROMISE(category && message && status <= fmi3Error);
}

static void update(fmi3InstanceEnvironment environment, double time, bool settable, bool gettable,
                   bool finished, bool can_end, bool *asked, double *end);

static fmi3Instance instantiate(const struct fmi3_api *api, const char *name, bool logging, struct subject *own)
{
    char token[64];

    snprintf(token, sizeof token, "{%016llx%016llx}", (unsigned long long)api->table_hash,
             (unsigned long long)FMU_START_HASH);
    return api->InstantiateCoSimulation(name, token, NULL, false, logging, false, own != NULL, NULL, 0, own,
                                        log_message, own ? update : NULL);
}

static struct block *inside(const struct subject *s)
{
    return block_of(s->c);
}

static void save_phases(struct subject *s)
{
    const struct fmi3_api *m = s->api;

    m->GetFMUState(s->c, &s->phase[0]);
    m->EnterConfigurationMode(s->c);
    m->GetFMUState(s->c, &s->phase[1]);
    m->ExitConfigurationMode(s->c);
    m->EnterInitializationMode(s->c, false, 0.0, 0.0, false, 0.0);
    m->GetFMUState(s->c, &s->phase[2]);
    m->ExitInitializationMode(s->c);
    m->GetFMUState(s->c, &s->phase[3]);
    m->Terminate(s->c);
    m->GetFMUState(s->c, &s->phase[4]);
}

/* The first plant has a host that neither sets inputs within a step nor lets it end early. */
static void open_subjects(void)
{
    for (int i = 0; i < INSTANCES; i++) {
        struct subject *s = &subjects[i];
        s->api = i < 2 ? &PLANT3 : &INVERSE3;
        s->slot = slots[i < 2 ? 0 : 1];
        s->c = instantiate(s->api, "fuzz", false, i ? s : NULL);
        FUZZ_PROMISE(s->c);
        save_phases(s);
    }
}

/* Most sequences begin with running instances: checking a parameter set takes longer than all else. */
static void begin(struct fuzz_bytes *in)
{
    const unsigned where = fuzz_byte(in);
    const int phase = where < 160 ? 3 : (int)(where % PHASES);

    for (int i = 0; i < INSTANCES; i++) {
        struct subject *s = &subjects[i];
        FUZZ_PROMISE(s->api->SetFMUState(s->c, s->phase[phase]) == fmi3OK);
        FUZZ_PROMISE(s->api->SetDebugLogging(s->c, false, 0, NULL) == fmi3OK);
    }
    blob_size = 0;
}

static void end(void)
{
    for (int i = 0; i < INSTANCES; i++)
        for (int k = 0; k < SLOTS; k++)
            FUZZ_PROMISE(subjects[i].api->FreeFMUState(subjects[i].c, &subjects[i].slot[k]) == fmi3OK);
}

/* --- arguments ----------------------------------------------------------------------------------- */

/* Most often as many values as the variables have; at times one more or less, or any number. */
struct arrays {
    size_t count;
    size_t value_count;
    fmi3ValueReference reference[4];
    const fmi3ValueReference *references; /* or NULL */
    double real[ARRAY];
    fmi3UInt64 integer[ARRAY];
    bool null;
};

static void arrays(struct fuzz_bytes *in, const struct subject *s, struct arrays *a)
{
    const struct fmu *fmu = s->c;
    const unsigned shape = fuzz_byte(in);

    a->count = shape < 192 ? 1 : shape % 4;
    a->value_count = 0;
    for (size_t i = 0; i < a->count; i++) {
        a->reference[i] = fuzz_reference(in, 24, FMU_TABLE_ROWS + 1); /* the last is time */
        const struct fmu_variable *v = fmu_find(fmu->model, a->reference[i]);
        a->value_count += v && v->index == 1 ? (size_t)*(const int *)((char *)fmu->parameters + v->count) : 1;
    }
    if (shape % 16 == 15)
        a->value_count = fuzz_byte(in) % ARRAY;
    if (a->value_count > ARRAY)
        a->value_count = ARRAY;
    for (size_t i = 0; i < a->value_count; i++) {
        a->real[i] = fuzz_number(in);
        a->integer[i] = shape == 200 ? UINT64_MAX - i : fuzz_byte(in) % 20;
    }
    a->null = shape >= 250;
    a->references = shape >= 253 ? NULL : a->reference;
}

/* --- promises ------------------------------------------------------------------------------------ */

static bool refused(fmi3Status status)
{
    return status == fmi3Discard || status == fmi3Error;
}

static void outputs_are_finite(const struct subject *s)
{
    static const fmi3ValueReference of_plant[] = { 4, 5 }, of_inverse[] = { 6 };
    const bool plant = s->api->kind == FMU_PLANT;
    const size_t count = plant ? 2 : 1;
    double value[2] = { 0.0, 0.0 };

    if (s->api->GetFloat64(s->c, plant ? of_plant : of_inverse, count, value, count) == fmi3OK)
        FUZZ_PROMISE(isfinite(value[0]) && isfinite(value[1]));
}

/* Before initialization is over outputs are computed when they are asked for: ask now, so that nothing moves. */
static void watch(struct subject *s)
{
    if (!((unsigned)inside(s)->s.phase & FMU_INITIALIZED))
        outputs_are_finite(s);
    s->before = *inside(s);
}

static void check(struct subject *s, fmi3Status status, enum allowed allowed)
{
    FUZZ_PROMISE(status == fmi3OK || status == fmi3Error || (status == fmi3Discard && allowed != OK_ERROR) ||
                 (status == fmi3Warning && allowed == STEP));
    if (refused(status)) {
        if (allowed == STEP && status == fmi3Discard)
            s->before.s.last_status = fmi3Discard;
        FUZZ_PROMISE(memcmp(&s->before, inside(s), sizeof s->before) == 0);
    } else
        outputs_are_finite(s);
}

/* --- calls --------------------------------------------------------------------------------------- */

static void call_get(struct subject *s, struct fuzz_bytes *in)
{
    const struct fmi3_api *m = s->api;
    const unsigned which = fuzz_byte(in);
    double values[ARRAY];
    fmi3UInt64 integers[ARRAY];
    bool flags[ARRAY];
    fmi3Int32 others[ARRAY];
    fmi3String strings[ARRAY];
    struct arrays a;

    arrays(in, s, &a);
    const size_t n = a.value_count;
    if (which < 160)
        check(s, m->GetFloat64(s->c, a.references, a.count, a.null ? NULL : values, n), OK_ERROR);
    else if (which < 192)
        check(s, m->GetUInt64(s->c, a.references, a.count, a.null ? NULL : integers, n), OK_ERROR);
    else if (which < 224)
        check(s, m->GetBoolean(s->c, a.references, a.count, a.null ? NULL : flags, n), OK_ERROR);
    else if (which < 240)
        check(s, m->GetInt32(s->c, a.references, a.count, others, n), OK_ERROR);
    else
        check(s, m->GetString(s->c, a.references, a.count, strings, n), OK_ERROR);
}

static void call_set(struct subject *s, struct fuzz_bytes *in)
{
    const struct fmi3_api *m = s->api;
    const unsigned which = fuzz_byte(in);
    static const bool flags[ARRAY] = { true };
    static const float singles[ARRAY] = { 1.0f };
    struct arrays a;

    arrays(in, s, &a);
    const double *reals = a.null ? NULL : a.real;
    if (which < 176)
        check(s, m->SetFloat64(s->c, a.references, a.count, reals, a.value_count), OK_DISCARD_ERROR);
    else if (which < 232)
        check(s, m->SetUInt64(s->c, a.references, a.count, a.null ? NULL : a.integer, a.value_count), OK_ERROR);
    else if (which < 244)
        check(s, m->SetBoolean(s->c, a.references, a.count, flags, a.value_count), OK_ERROR);
    else
        check(s, m->SetFloat32(s->c, a.references, a.count, singles, a.value_count), OK_ERROR);
}

/* New lengths, with values for what is new, as a host that resizes does. */
static void call_resize(struct subject *s, struct fuzz_bytes *in)
{
    const struct fmi3_api *m = s->api;
    const struct fmu *fmu = s->c;
    const unsigned which = fuzz_byte(in);
    unsigned row = 0;

    if (m->EnterConfigurationMode(s->c) != fmi3OK)
        return;
    for (unsigned left = which % 3;; row++) { /* the group that is resized */
        const struct fmu_variable *v = fmu_find(fmu->model, row);
        if (v && v->base == FMU_INTEGER && left-- == 0)
            break;
    }
    const fmi3UInt64 count = fuzz_byte(in) % (PLAY_MAX + 2); /* the longest of all, and beyond */
    const fmi3Status status = m->SetUInt64(s->c, &row, 1, &count, 1);
    FUZZ_PROMISE(status == fmi3OK || status == fmi3Error);
    FUZZ_PROMISE(m->ExitConfigurationMode(s->c) == fmi3OK);
    for (unsigned first = row + 1; fmu_find(fmu->model, first) && fmu->model->table[first].index == 1;
         first++) {
        double values[PLAY_MAX];
        for (size_t k = 0; k < PLAY_MAX; k++)
            values[k] = (double)(fuzz_byte(in) + 1) * 7e-8;
        if (status == fmi3OK)
            FUZZ_PROMISE(m->SetFloat64(s->c, &first, 1, values, count) == fmi3OK);
    }
}

static void call_lifecycle(struct subject *s, struct fuzz_bytes *in)
{
    const struct fmi3_api *m = s->api;
    const unsigned which = fuzz_byte(in);

    switch (which % 8) {
    case 0:
    case 1: {
        const double start = fuzz_number(in), stop = fuzz_number(in), tolerance = fuzz_number(in);
        check(s, m->EnterInitializationMode(s->c, which & 16, tolerance, start, which & 32, stop), OK_ERROR);
        break;
    }
    case 2: check(s, m->EnterInitializationMode(s->c, false, 0.0, 0.0, false, 0.0), OK_ERROR); break;
    case 3: check(s, m->ExitInitializationMode(s->c), OK_ERROR); break;
    case 4: check(s, m->EnterConfigurationMode(s->c), OK_ERROR); break;
    case 5: check(s, m->ExitConfigurationMode(s->c), OK_ERROR); break;
    case 6: check(s, which & 16 ? m->Terminate(s->c) : m->EnterEventMode(s->c), OK_ERROR); break;
    default: check(s, m->Reset(s->c), OK_ERROR);
    }
}

static double step_size(struct fuzz_bytes *in, double sample_time)
{
    static const double SPECIAL[] = { 0.0, -0.0, NAN, INFINITY, -INFINITY, -1.0, 1e300, 5e-324 };
    const unsigned kind = fuzz_byte(in);

    if (kind < 8)
        return SPECIAL[kind];
    if (kind < 64)
        return sample_time * (fuzz_short(in) % TICKS);
    if (kind < 192)
        return sample_time * fuzz_byte(in) / 16.0;
    return sample_time;
}

static void make_step(struct subject *s, struct fuzz_bytes *in, double time, double step)
{
    bool event = true, terminate = true, early = false;
    double reached = NAN;

    bytes = in;
    s->last_update = time;
    s->step_end = time + step;
    const fmi3Status status = s->api->DoStep(s->c, time, step, true, &event, &terminate, &early, &reached);
    check(s, status, STEP);
    if (refused(status))
        return;
    const double slack = 1e-9 * inside(s)->parameter.sampleTime + 1e-14 * fabs(time);
    FUZZ_PROMISE(!event && reached >= time && reached <= s->step_end + slack);
    FUZZ_PROMISE(early == (reached < s->step_end - slack) || fabs(reached - s->step_end) <= slack);
    FUZZ_PROMISE(s != &subjects[0] || !early);
}

static void call_step(struct subject *s, struct fuzz_bytes *in)
{
    const double now = inside(s)->s.clock.time;
    const double step = step_size(in, inside(s)->parameter.sampleTime);

    make_step(s, in, fuzz_byte(in) < 240 ? now : fuzz_number(in), step);
}

static void call_ordinary_step(struct subject *s, struct fuzz_bytes *in)
{
    const bool plant = s->api->kind == FMU_PLANT;
    const fmi3ValueReference input = plant ? 0 : 1;
    const double value = fuzz_byte(in) * (plant ? 0.5 : 7e-8);
    const unsigned ticks = fuzz_byte(in) % 8;

    check(s, s->api->SetFloat64(s->c, &input, 1, &value, 1), OK_DISCARD_ERROR);
    watch(s);
    make_step(s, in, inside(s)->s.clock.time, (ticks + 1) * inside(s)->parameter.sampleTime);
}

/* Within a step: what may be called may be called, what may not is refused, and time goes on. */
static void update(fmi3InstanceEnvironment environment, double time, bool settable, bool gettable,
                   bool finished, bool can_end, bool *asked, double *end)
{
    struct subject *s = environment;
    const struct fmi3_api *m = s->api;
    const fmi3ValueReference input = s->api->kind == FMU_PLANT ? 0 : 1;
    const unsigned which = fuzz_byte(bytes);
    fmi3FMUState state = NULL;
    double value;

    FUZZ_PROMISE(settable && gettable && finished && can_end && !*asked);
    FUZZ_PROMISE(time >= s->last_update && time <= s->step_end);
    FUZZ_PROMISE(m->GetFloat64(s->c, &input, 1, &value, 1) == fmi3OK && isfinite(value));
    outputs_are_finite(s);
    s->last_update = time;
    if (which < 160) {
        value = fuzz_number(bytes);
        const fmi3Status status = m->SetFloat64(s->c, &input, 1, &value, 1);
        FUZZ_PROMISE(status == (isfinite(value) ? fmi3OK : fmi3Discard));
    } else if (which < 176) {
        FUZZ_PROMISE(m->Terminate(s->c) == fmi3Error && m->Reset(s->c) == fmi3Error);
        FUZZ_PROMISE(m->GetFMUState(s->c, &state) == fmi3Error && !state);
        m->FreeInstance(s->c); /* refused */
    } else if (which < 200) {
        *asked = true;
        *end = fuzz_number(bytes);
    }
}

static void call_derivative(struct subject *s, struct fuzz_bytes *in)
{
    struct arrays of, by;
    double values[ARRAY] = { 0.0 };
    const bool adjoint = fuzz_byte(in) & 1;

    arrays(in, s, &of);
    arrays(in, s, &by);
    const struct arrays *from = adjoint ? &of : &by, *to = adjoint ? &by : &of;
    const fmi3Status status = (adjoint ? s->api->GetAdjointDerivative : s->api->GetDirectionalDerivative)(
        s->c, of.references, of.count, by.references, by.count, from->null ? NULL : from->real,
        from->value_count, to->null ? NULL : values, to->value_count);
    check(s, status, OK_DISCARD_ERROR);
    for (size_t i = 0; i < from->value_count; i++)
        if (!isfinite(from->real[i]))
            return;
    for (size_t i = 0; i < to->value_count && status == fmi3OK && !adjoint; i++)
        FUZZ_PROMISE(isfinite(values[i]));
}

static void call_state(struct subject *s, struct fuzz_bytes *in)
{
    const struct fmi3_api *m = s->api;
    const unsigned which = fuzz_byte(in);
    fmi3FMUState *slot = &s->slot[which / 8 % SLOTS];
    size_t size = 0;

    switch (which % 8) {
    case 0:
    case 1: check(s, m->GetFMUState(s->c, which < 250 ? slot : NULL), OK_ERROR); break;
    case 2: check(s, m->SetFMUState(s->c, *slot), OK_ERROR); break;
    case 3: check(s, m->FreeFMUState(s->c, which < 250 ? slot : NULL), OK_ERROR); break;
    case 4:
    case 5:
        if (m->SerializedFMUStateSize(s->c, *slot, &size) == fmi3OK) {
            FUZZ_PROMISE(size <= BLOB && m->SerializeFMUState(s->c, *slot, blob, size) == fmi3OK);
            blob_size = size;
        }
        break;
    default:
        if (which & 64 && blob_size)
            blob[fuzz_short(in) % blob_size] ^= (fmi3Byte)fuzz_byte(in);
        fmi3FMUState state = NULL;
        const fmi3Status status = m->DeserializeFMUState(s->c, blob, blob_size, &state);
        check(s, status, OK_ERROR);
        if (status == fmi3OK) {
            FUZZ_PROMISE(m->FreeFMUState(s->c, slot) == fmi3OK);
            *slot = state;
        }
    }
}

/* Back to a state and the same step, with the same host within it: the same bits. */
static void call_rollback(struct subject *s, struct fuzz_bytes *in)
{
    struct fuzz_bytes again = *in;
    struct block first;
    fmi3FMUState state = NULL;

    FUZZ_PROMISE(s->api->GetFMUState(s->c, &state) == fmi3OK);
    call_ordinary_step(s, in);
    first = *inside(s);
    FUZZ_PROMISE(s->api->SetFMUState(s->c, state) == fmi3OK);
    watch(s);
    call_ordinary_step(s, &again);
    FUZZ_PROMISE(memcmp(&first, inside(s), sizeof first) == 0);
    s->api->FreeFMUState(s->c, &state);
}

/* Instances that come and go, and ones that are refused. */
static void call_instantiate(struct subject *s, struct fuzz_bytes *in)
{
    static const char *const NAMES[] = { "x", "", NULL, "%s%n" };
    const unsigned which = fuzz_byte(in);
    char token[64];
    fmi3Instance c = NULL;

    if (which < 128)
        c = instantiate(s->api, NAMES[which % 4], which & 8, NULL);
    else {
        fuzz_take(in, token, sizeof token - 1);
        token[sizeof token - 1] = '\0';
        if (which & 1)
            c = s->api->InstantiateModelExchange("x", token, "no/such", false, false, NULL, log_message);
        else
            c = s->api->InstantiateCoSimulation("x", token, "no/such", false, false, which & 2, false, NULL, 0,
                                                NULL, which & 4 ? log_message : NULL, NULL);
        FUZZ_PROMISE(!c);
    }
    s->api->FreeInstance(c);
}

/* Without an instance. */
static void call_null(struct subject *s, struct fuzz_bytes *in)
{
    const struct fmi3_api *m = s->api;
    fmi3FMUState state = NULL;
    bool flag;
    double time;

    (void)in;
    FUZZ_PROMISE(m->DoStep(NULL, 0.0, 1.0, true, &flag, &flag, &flag, &time) == fmi3Error);
    FUZZ_PROMISE(m->Reset(NULL) == fmi3Error && m->Terminate(NULL) == fmi3Error);
    FUZZ_PROMISE(m->GetFMUState(NULL, &state) == fmi3Error && m->SetFMUState(NULL, NULL) == fmi3Error);
    FUZZ_PROMISE(m->GetFloat64(NULL, NULL, 0, NULL, 0) == fmi3Error);
    FUZZ_PROMISE(m->SetUInt64(NULL, NULL, 0, NULL, 0) == fmi3Error);
    FUZZ_PROMISE(m->EnterConfigurationMode(NULL) == fmi3Error);
    FUZZ_PROMISE(m->GetAdjointDerivative(NULL, NULL, 0, NULL, 0, NULL, 0, NULL, 0) == fmi3Error);
    m->FreeInstance(NULL);
}

typedef void call(struct subject *, struct fuzz_bytes *);

static call *const CALL[] = {
    call_ordinary_step, call_ordinary_step, call_step,        call_step,     call_set,        call_set,
    call_get,           call_state,         call_state,       call_rollback, call_derivative, call_lifecycle,
    call_lifecycle,     call_resize,        call_instantiate, call_null,
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
