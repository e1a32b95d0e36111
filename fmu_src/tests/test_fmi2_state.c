/* FMU states: bit-exact, movable between instances, and damaged bytes are refused. */
#include "fmi2_fixture.h"

CHECK_MAIN;

static void steps(const struct fmi2_api *m, fmi2Component c, int from, int to, double *out)
{
    for (int k = from; k < to; k++) {
        CHECK(set_real(m, c, input_of(m), signal(m, k * TS)) == fmi2OK);
        CHECK(set_slope(m, c, input_of(m), 1e-5 * k) == fmi2OK);
        CHECK(m->DoStep(c, k * TS, TS, fmi2True) == fmi2OK);
        if (out)
            out[k] = get_real(m, c, output_of(m));
    }
}

static void back_and_forth(const struct fmi2_api *m)
{
    double first[60], second[60];
    fmi2Component c = make_running(m, 0.0), other = make_running(m, 0.0);
    fmi2FMUstate state = NULL;
    struct state_bytes bytes, again;

    steps(m, c, 0, 30, first);
    CHECK(m->GetFMUstate(c, &state) == fmi2OK && state);
    read_state(m, c, &bytes);
    steps(m, c, 30, 60, first);
    const fmi2FMUstate same = state;
    CHECK(m->SetFMUstate(c, state) == fmi2OK);
    read_state(m, c, &again);
    CHECK(same_state(&bytes, &again));
    steps(m, c, 30, 60, second);
    CHECK(memcmp(first + 30, second + 30, 30 * sizeof(double)) == 0);
    CHECK(m->SetFMUstate(other, state) == fmi2OK); /* another instance goes on from there */
    steps(m, other, 30, 60, second);
    CHECK(memcmp(first + 30, second + 30, 30 * sizeof(double)) == 0);
    CHECK(m->GetFMUstate(c, &state) == fmi2OK && state == same); /* a state is overwritten in place */
    CHECK(m->FreeFMUstate(c, &state) == fmi2OK && state == NULL);
    CHECK(m->FreeFMUstate(c, &state) == fmi2OK);
    CHECK(m->FreeFMUstate(c, NULL) == fmi2OK);
    m->FreeInstance(c);
    m->FreeInstance(other);
}

static void serialized(const struct fmi2_api *m)
{
    double first[60], second[60];
    fmi2Component c = make_running(m, 0.0);
    struct state_bytes bytes, again;
    int garbage = 0;
    fmi2FMUstate state = &garbage; /* masters pass it uninitialised */

    steps(m, c, 0, 30, first);
    read_state(m, c, &bytes);
    steps(m, c, 30, 60, first);
    m->FreeInstance(c);
    c = make(m); /* a new instance, not even initialised */
    CHECK(m->DeSerializeFMUstate(c, bytes.byte, bytes.size, &state) == fmi2OK);
    CHECK(m->SetFMUstate(c, state) == fmi2OK);
    read_state(m, c, &again);
    CHECK(same_state(&bytes, &again));
    steps(m, c, 30, 60, second);
    CHECK(memcmp(first + 30, second + 30, 30 * sizeof(double)) == 0);
    CHECK(m->FreeFMUstate(c, &state) == fmi2OK);
    m->FreeInstance(c);
}

/* Same history, same bytes: nothing uninitialised is saved. */
static void same_history_same_bytes(const struct fmi2_api *m)
{
    struct state_bytes a, b;
    fmi2Component c = make_running(m, 0.0), d;

    steps(m, c, 0, 20, NULL);
    d = make_running(m, 0.0);
    steps(m, d, 0, 20, NULL);
    read_state(m, c, &a);
    read_state(m, d, &b);
    CHECK(same_state(&a, &b));
    m->FreeInstance(c);
    m->FreeInstance(d);
}

/* Every phase can be saved and returned to. */
static void phases(const struct fmi2_api *m)
{
    for (unsigned from = 1; from <= 8; from *= 2)
        for (unsigned to = 1; to <= 8; to *= 2) {
            fmi2Component c = make_in_phase(m, (enum fmu_phase)from), d = make_in_phase(m, (enum fmu_phase)to);
            struct state_bytes before, after;
            fmi2FMUstate state = NULL;
            CHECK(m->GetFMUstate(c, &state) == fmi2OK);
            read_state(m, c, &before);
            CHECK(m->SetFMUstate(d, state) == fmi2OK);
            read_state(m, d, &after);
            CHECK(same_state(&before, &after));
            CHECK((m->DoStep(d, 0.0, TS, fmi2True) <= fmi2Warning) == (from == FMU_STEP_COMPLETE));
            CHECK((m->ExitInitializationMode(d) == fmi2OK) == (from == FMU_INITIALIZATION));
            m->FreeFMUstate(d, &state);
            m->FreeInstance(c);
            m->FreeInstance(d);
        }
}

/* Parameters belong to the state: they return, and the model follows them. */
static void parameters_return(const struct fmi2_api *m)
{
    fmi2Component c = make_initializing(m, 0.0);
    fmi2FMUstate state = NULL;

    CHECK(m->GetFMUstate(c, &state) == fmi2OK);
    const double before = get_real(m, c, output_of(m));
    CHECK(set_real(m, c, "initialDisplacement", 4e-6) == fmi2OK);
    CHECK(set_real(m, c, "rule[1].q3", 1.7e-6) == fmi2OK);
    CHECK(get_real(m, c, output_of(m)) != before);
    CHECK(m->SetFMUstate(c, state) == fmi2OK);
    CHECK(get_real(m, c, output_of(m)) == before);
    CHECK(get_real(m, c, "rule[1].q3") == start_parameters()->rule[0].q3);
    m->FreeFMUstate(c, &state);
    m->FreeInstance(c);
}

/* Whichever way an instance came to a state, with parameters prepared, in use or others before, it goes on from
 * there to the same bits. */
static void same_ticks_from_everywhere(const struct fmi2_api *m)
{
    enum { WAYS = 5, FROM = 100, TO = 1100 };
    static double first[TO], second[TO];
    fmi2Component c = make_running(m, 0.0);
    fmi2Component way[WAYS] = { make(m), make_initializing(m, 0.0), make_initializing(m, 0.0), make(m), c };
    fmi2FMUstate state = NULL;

    CHECK(isfinite(get_real(m, way[2], output_of(m))));         /* its parameters are prepared */
    CHECK(set_real(m, way[3], "rule[1].q3", 1.7e-6) == fmi2OK); /* another model, at work */
    CHECK(m->EnterInitializationMode(way[3]) == fmi2OK && m->ExitInitializationMode(way[3]) == fmi2OK);
    steps(m, way[3], 0, 10, NULL);
    steps(m, c, 0, FROM, first);
    CHECK(m->GetFMUstate(c, &state) == fmi2OK);
    steps(m, c, FROM, TO, first);
    CHECK(m->Reset(c) == fmi2OK && m->EnterInitializationMode(c) == fmi2OK);
    CHECK(isfinite(get_real(m, c, output_of(m))));
    for (int i = 0; i < WAYS; i++) {
        CHECK(m->SetFMUstate(way[i], state) == fmi2OK);
        steps(m, way[i], FROM, TO, second);
        CHECK(memcmp(first + FROM, second + FROM, (TO - FROM) * sizeof *first) == 0);
    }
    m->FreeFMUstate(c, &state);
    for (int i = 0; i < WAYS; i++)
        m->FreeInstance(way[i]);
}

static bool refused(const struct fmi2_api *m, fmi2Component c, const fmi2Byte *bytes, size_t size)
{
    int untouched = 0;
    fmi2FMUstate state = &untouched;

    return m->DeSerializeFMUstate(c, bytes, size, &state) == fmi2Error && state == &untouched;
}

static void damage(const struct fmi2_api *m)
{
    fmi2Component c = make_running(m, 0.0);
    struct state_bytes bytes;
    fmi2Byte longer[STATE_CAPACITY + 1] = { 0 };
    struct state_bytes before, after;
    long accepted = 0;

    steps(m, c, 0, 10, NULL);
    read_state(m, c, &bytes);
    read_state(m, c, &before);
    for (size_t i = 0; i < bytes.size; i++)
        for (int flip = 0; flip < 9; flip++) {
            const fmi2Byte good = bytes.byte[i];
            bytes.byte[i] = (fmi2Byte)(good ^ (flip < 8 ? 1 << flip : 0xff));
            accepted += !refused(m, c, bytes.byte, bytes.size);
            bytes.byte[i] = good;
        }
    CHECK(accepted == 0);
    memcpy(longer, bytes.byte, bytes.size);
    for (size_t size = 0; size < bytes.size; size += 7)
        CHECK(refused(m, c, longer, size));
    CHECK(refused(m, c, longer, bytes.size - 1) && log_says("no state"));
    CHECK(refused(m, c, longer, bytes.size + 1));
    memset(longer, 0, sizeof longer);
    CHECK(refused(m, c, longer, bytes.size) && log_says("damaged"));
    read_state(m, c, &after);
    CHECK(same_state(&before, &after));
    m->FreeInstance(c);
}

/* A snapshot as a serialized state, under a checksum that is right. */
static void forge(const struct fmi2_api *m, fmi2Component c, const struct block *snapshot,
                  struct state_bytes *bytes)
{
    enum { HEADER = 40, CHECKSUM = 32 };
    const uint64_t checksum = fmu_hash(snapshot, sizeof *snapshot);

    read_state(m, c, bytes);
    memcpy(bytes->byte + CHECKSUM, &checksum, sizeof checksum);
    memcpy(bytes->byte + HEADER, snapshot, sizeof *snapshot);
}

/* What cannot be is refused with its reason. */
static bool refused_when(const struct fmi2_api *m, fmi2Component c, struct block snapshot, const char *reason)
{
    struct state_bytes bytes;

    forge(m, c, &snapshot, &bytes);
    return refused(m, c, bytes.byte, bytes.size) && log_says(reason);
}

static void inventions(const struct fmi2_api *m)
{
    fmi2Component c = make_running(m, 0.0);
    struct block s;

    steps(m, c, 0, 10, NULL);
    const struct block good = *block_of(c);
    s = good, s.s.phase = 3;
    CHECK(refused_when(m, c, s, "phase"));
    s = good, s.s.last_status = 7;
    CHECK(refused_when(m, c, s, "status"));
    s = good, s.state.core.y = NAN;
    CHECK(refused_when(m, c, s, "finite"));
    s = good, s.s.last_step.end_tick = s.s.last_step.first_tick - 1;
    CHECK(refused_when(m, c, s, "ticks"));
    s = good, s.s.warned = FMU_NOT_FINITE; /* as if a step without finite numbers were known */
    CHECK(refused_when(m, c, s, "finding"));
    s = good, s.parameter.rule[1].sigmaLower = -1.0;
    CHECK(refused_when(m, c, s, "rule[2].sigmaLower"));
    s = good, s.parameter.ruleCount = 4;
    CHECK(refused_when(m, c, s, "packaged with 3"));
    s = good, s.s.clock.next_tick = INT64_MAX;
    CHECK(refused_when(m, c, s, "ticks"));
    s = good, s.s.last_step.first_tick = INT64_MIN / 2;
    CHECK(refused_when(m, c, s, "ticks"));
    m->FreeInstance(c);
}

/* Places of a snapshot that hold integers: from here, so many bytes. */
static const struct {
    size_t begin, size;
} INTEGERS[] = {
#define WORD(member) { offsetof(struct block, member), 8 }
    WORD(s.phase), /* and last_status */
    { offsetof(struct block, parameter.ruleCount),
      offsetof(struct chain_parameters, rule) - offsetof(struct chain_parameters, ruleCount) },
    { offsetof(struct block, s.output.flag), sizeof(((struct fmu_outputs *)0)->flag) },
    WORD(s.clock.tick),
    WORD(s.clock.next_tick),
    WORD(s.clock.additions),
    WORD(s.last_step.tick),
    WORD(s.last_step.first_tick),
    WORD(s.last_step.end_tick),
    WORD(s.warned),
};

static bool holds_integers(size_t place)
{
    for (size_t i = 0; i < sizeof INTEGERS / sizeof INTEGERS[0]; i++)
        if (place - INTEGERS[i].begin < INTEGERS[i].size)
            return true;
    return false;
}

/* All that an instance hands out is finite, and its steps return. */
static void harmless(const struct fmi2_api *m, fmi2Component c)
{
    const struct fmu_model *model = m->kind == FMU_PLANT ? &plant_model : &inverse_model;
    const enum fmu_phase phase = (enum fmu_phase)block_of(c)->s.phase;
    const double seed = 1.0;
    const fmi2ValueReference in = reference_of(m, input_of(m)), out = reference_of(m, output_of(m));
    double value = 0.0;

    if (phase == FMU_STEP_COMPLETE) {
        CHECK(m->GetRealStatus(c, fmi2LastSuccessfulTime, &value) == fmi2OK && isfinite(value));
        if (m->GetDirectionalDerivative(c, &out, 1, &in, 1, &seed, &value) == fmi2OK)
            CHECK(isfinite(value));
        m->DoStep(c, value, 3 * TS, fmi2True);
    }
    for (fmi2ValueReference r = 0; r < 1000 && phase != FMU_INSTANTIATED; r++) {
        const struct fmu_variable *v = fmu_find(model, r);
        if (v && v->base == FMU_REAL && m->GetReal(c, &r, 1, &value) == fmi2OK)
            CHECK(isfinite(value));
    }
}

/* Each eight bytes of a state in turn are what no run leaves there. No number is let through that is none;
 * where integers are, some may be possible, and then nothing bad follows. */
static void planted(const struct fmi2_api *m, enum fmu_phase phase)
{
    static const union {
        double number;
        int64_t integer;
    } SEEDS[] = { { .number = NAN },
                  { .number = INFINITY },
                  { .number = -INFINITY },
                  { .integer = INT64_MAX },
                  { .integer = INT64_MIN },
                  { .integer = -1 },
                  { .integer = INT64_C(1) << 62 },
                  { .integer = 0x7fffffff } };
    const size_t seeds = sizeof SEEDS / sizeof SEEDS[0];
    fmi2Component c = make_in_phase(m, phase);
    struct block *now = block_of(c);
    struct state_bytes bytes;
    long let_through = 0;

    if (phase == FMU_STEP_COMPLETE)
        steps(m, c, 0, 10, NULL);
    const struct block good = *now;
    for (size_t place = 0; place < sizeof good; place += 8)
        for (size_t i = 0; i < (holds_integers(place) ? seeds : 3); i++) {
            struct block s = good;
            fmi2FMUstate state = NULL;
            memcpy((char *)&s + place, &SEEDS[i], 8);
            memcpy(now, &good, sizeof good);
            forge(m, c, &s, &bytes);
            if (m->DeSerializeFMUstate(c, bytes.byte, bytes.size, &state) != fmi2OK)
                continue;
            let_through += !holds_integers(place) && s.s.clock.stop_time != INFINITY;
            CHECK(m->SetFMUstate(c, state) == fmi2OK);
            harmless(m, c);
            m->FreeFMUstate(c, &state);
        }
    CHECK(let_through == 0);
    m->FreeInstance(c);
}

/* Ticks that no step could have. */
static void absurd_ticks(const struct fmi2_api *m)
{
    static const int64_t TICKS[] = { INT64_MAX, INT64_MIN, INT64_C(1) << 62, INT64_C(1) << 54, -1 };
    static const size_t PLACES[] = {
        offsetof(struct block, s.clock.tick),
        offsetof(struct block, s.clock.next_tick),
        offsetof(struct block, s.last_step.tick),
        offsetof(struct block, s.last_step.end_tick),
    };
    fmi2Component c = make_running(m, 0.0);

    steps(m, c, 0, 10, NULL);
    for (size_t place = 0; place < sizeof PLACES / sizeof PLACES[0]; place++)
        for (size_t i = 0; i < sizeof TICKS / sizeof TICKS[0]; i++) {
            struct block s = *block_of(c);
            memcpy((char *)&s + PLACES[place], &TICKS[i], 8);
            if (TICKS[i] != -1 || place != 2) /* where the last step began may have been before 0 */
                CHECK(refused_when(m, c, s, "ticks"));
        }
    m->FreeInstance(c);
}

static void other_model(void)
{
    fmi2Component plant = make_running(&PLANT, 0.0), inverse = make_running(&INVERSE, 0.0);
    struct state_bytes bytes;

    read_state(&PLANT, plant, &bytes);
    CHECK(refused(&INVERSE, inverse, bytes.byte, bytes.size) && log_says("IT2Inverse"));
    PLANT.FreeInstance(plant);
    INVERSE.FreeInstance(inverse);
}

static void null_pointers(const struct fmi2_api *m)
{
    fmi2Component c = make_running(m, 0.0);
    fmi2FMUstate state = NULL;
    fmi2Byte bytes[8];
    size_t size;

    CHECK(m->GetFMUstate(c, NULL) == fmi2Error && log_says("null"));
    CHECK(m->SetFMUstate(c, NULL) == fmi2Error && log_says("null"));
    CHECK(m->SerializedFMUstateSize(c, NULL, &size) == fmi2Error && log_says("null"));
    CHECK(m->GetFMUstate(c, &state) == fmi2OK);
    CHECK(m->SerializedFMUstateSize(c, state, NULL) == fmi2Error && log_says("null"));
    CHECK(m->SerializeFMUstate(c, NULL, bytes, 8) == fmi2Error && log_says("null"));
    CHECK(m->SerializeFMUstate(c, state, NULL, 8) == fmi2Error && log_says("null"));
    CHECK(m->SerializeFMUstate(c, state, bytes, 8) == fmi2Error && log_says("too few"));
    CHECK(m->DeSerializeFMUstate(c, NULL, 8, &state) == fmi2Error && log_says("null"));
    CHECK(m->DeSerializeFMUstate(c, bytes, 8, NULL) == fmi2Error && log_says("null"));
    CHECK(m->FreeFMUstate(c, &state) == fmi2OK);
    m->FreeInstance(c);
}

static void of_model(const struct fmi2_api *m)
{
    back_and_forth(m);
    serialized(m);
    same_history_same_bytes(m);
    phases(m);
    parameters_return(m);
    same_ticks_from_everywhere(m);
    damage(m);
    inventions(m);
    absurd_ticks(m);
    planted(m, FMU_INSTANTIATED);
    planted(m, FMU_INITIALIZATION);
    planted(m, FMU_STEP_COMPLETE);
    null_pointers(m);
}

int main(void)
{
    of_model(&PLANT);
    of_model(&INVERSE);
    other_model();
    return check_report("fmi2 state");
}
