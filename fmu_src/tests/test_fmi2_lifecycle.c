/* Life cycle and call order: every function in every phase, null pointers, instances side by side. */
#include "fmi2_fixture.h"

CHECK_MAIN;

static fmi2FMUstate held; /* of the model under test, for the calls that need one */
static fmi2Byte bytes[STATE_CAPACITY];

/* Each function of the standard with arguments that are right, whatever the phase. */
typedef fmi2Status call(const struct fmi2_api *, fmi2Component);

static fmi2Status set_debug_logging(const struct fmi2_api *m, fmi2Component c)
{
    return m->SetDebugLogging(c, fmi2False, 0, NULL);
}

static fmi2Status setup_experiment(const struct fmi2_api *m, fmi2Component c)
{
    return m->SetupExperiment(c, fmi2True, 1e-6, 0.0, fmi2True, 1.0);
}

static fmi2Status enter_initialization(const struct fmi2_api *m, fmi2Component c)
{
    return m->EnterInitializationMode(c);
}

static fmi2Status exit_initialization(const struct fmi2_api *m, fmi2Component c)
{
    return m->ExitInitializationMode(c);
}

static fmi2Status terminate(const struct fmi2_api *m, fmi2Component c)
{
    return m->Terminate(c);
}

static fmi2Status reset(const struct fmi2_api *m, fmi2Component c)
{
    return m->Reset(c);
}

static fmi2Status get_a_real(const struct fmi2_api *m, fmi2Component c)
{
    const fmi2ValueReference r = reference_of(m, output_of(m));
    double value;
    return m->GetReal(c, &r, 1, &value);
}

static fmi2Status get_an_integer(const struct fmi2_api *m, fmi2Component c)
{
    const fmi2ValueReference r = reference_of(m, "ruleCount");
    int value;
    return m->GetInteger(c, &r, 1, &value);
}

static fmi2Status get_no_boolean(const struct fmi2_api *m, fmi2Component c)
{
    return m->GetBoolean(c, NULL, 0, NULL);
}

static fmi2Status get_no_string(const struct fmi2_api *m, fmi2Component c)
{
    return m->GetString(c, NULL, 0, NULL);
}

static fmi2Status set_a_real(const struct fmi2_api *m, fmi2Component c)
{
    return set_real(m, c, input_of(m), signal(m, 0.0));
}

static fmi2Status set_no_integer(const struct fmi2_api *m, fmi2Component c)
{
    return m->SetInteger(c, NULL, 0, NULL);
}

static fmi2Status set_no_boolean(const struct fmi2_api *m, fmi2Component c)
{
    return m->SetBoolean(c, NULL, 0, NULL);
}

static fmi2Status set_no_string(const struct fmi2_api *m, fmi2Component c)
{
    return m->SetString(c, NULL, 0, NULL);
}

static fmi2Status get_state(const struct fmi2_api *m, fmi2Component c)
{
    return m->GetFMUstate(c, &held);
}

static fmi2Status set_state(const struct fmi2_api *m, fmi2Component c)
{
    return m->SetFMUstate(c, held);
}

static fmi2Status free_no_state(const struct fmi2_api *m, fmi2Component c)
{
    fmi2FMUstate none = NULL;
    return m->FreeFMUstate(c, &none);
}

static fmi2Status state_size(const struct fmi2_api *m, fmi2Component c)
{
    size_t size;
    return m->SerializedFMUstateSize(c, held, &size);
}

static fmi2Status serialize(const struct fmi2_api *m, fmi2Component c)
{
    return m->SerializeFMUstate(c, held, bytes, sizeof bytes);
}

static fmi2Status deserialize(const struct fmi2_api *m, fmi2Component c)
{
    fmi2FMUstate state = NULL;
    size_t size = 0;
    fmi2Status status;

    if (c)
        CHECK(m->SerializedFMUstateSize(c, held, &size) == fmi2OK && serialize(m, c) == fmi2OK);
    status = m->DeSerializeFMUstate(c, bytes, size, &state);
    if (c)
        m->FreeFMUstate(c, &state);
    return status;
}

static fmi2Status directional_derivative(const struct fmi2_api *m, fmi2Component c)
{
    const fmi2ValueReference unknown = reference_of(m, output_of(m));
    const fmi2ValueReference known = reference_of(m, input_of(m));
    const double seed = 1.0;
    double value;
    return m->GetDirectionalDerivative(c, &unknown, 1, &known, 1, &seed, &value);
}

static fmi2Status set_input_derivatives(const struct fmi2_api *m, fmi2Component c)
{
    return set_slope(m, c, input_of(m), 0.0);
}

/* Refused where it is allowed too (maxOutputDerivativeOrder is 0): see output_derivatives below. */
static fmi2Status get_output_derivatives(const struct fmi2_api *m, fmi2Component c)
{
    const fmi2ValueReference r = reference_of(m, output_of(m));
    const fmi2Integer order = 1;
    double value;
    return m->GetRealOutputDerivatives(c, &r, 1, &order, &value);
}

/* A reference that jumps may ask for a voltage out of range: a warning, but the step is made. */
static fmi2Status do_step(const struct fmi2_api *m, fmi2Component c)
{
    const fmi2Status status = m->DoStep(c, 0.0, TS, fmi2True);
    return status == fmi2Warning ? fmi2OK : status;
}

static fmi2Status get_status(const struct fmi2_api *m, fmi2Component c)
{
    fmi2Status value;
    return m->GetStatus(c, fmi2DoStepStatus, &value);
}

static fmi2Status get_real_status(const struct fmi2_api *m, fmi2Component c)
{
    double value;
    return m->GetRealStatus(c, fmi2LastSuccessfulTime, &value);
}

static fmi2Status get_boolean_status(const struct fmi2_api *m, fmi2Component c)
{
    fmi2Boolean value;
    return m->GetBooleanStatus(c, fmi2Terminated, &value);
}

static fmi2Status get_string_status(const struct fmi2_api *m, fmi2Component c)
{
    fmi2String value;
    return m->GetStringStatus(c, fmi2PendingStatus, &value);
}

enum { I = FMU_INSTANTIATED, M = FMU_INITIALIZATION, S = FMU_STEP_COMPLETE, T = FMU_TERMINATED };

/* The standard's table of allowed calls (FMI 2.0.4, 4.2.4). */
static const struct {
    const char *name;
    call *function;
    unsigned allowed;
} CALLS[] = {
    { "fmi2SetDebugLogging", set_debug_logging, I | M | S | T },
    { "fmi2SetupExperiment", setup_experiment, I },
    { "fmi2EnterInitializationMode", enter_initialization, I },
    { "fmi2ExitInitializationMode", exit_initialization, M },
    { "fmi2Terminate", terminate, S },
    { "fmi2Reset", reset, I | M | S | T },
    { "fmi2GetReal", get_a_real, M | S | T },
    { "fmi2GetInteger", get_an_integer, M | S | T },
    { "fmi2GetBoolean", get_no_boolean, M | S | T },
    { "fmi2GetString", get_no_string, M | S | T },
    { "fmi2SetReal", set_a_real, I | M | S },
    { "fmi2SetInteger", set_no_integer, I | M | S },
    { "fmi2SetBoolean", set_no_boolean, I | M | S },
    { "fmi2SetString", set_no_string, I | M | S },
    { "fmi2GetFMUstate", get_state, I | M | S | T },
    { "fmi2SetFMUstate", set_state, I | M | S | T },
    { "fmi2FreeFMUstate", free_no_state, I | M | S | T },
    { "fmi2SerializedFMUstateSize", state_size, I | M | S | T },
    { "fmi2SerializeFMUstate", serialize, I | M | S | T },
    { "fmi2DeSerializeFMUstate", deserialize, I | M | S | T },
    { "fmi2GetDirectionalDerivative", directional_derivative, M | S | T },
    { "fmi2SetRealInputDerivatives", set_input_derivatives, I | M | S },
    { "fmi2DoStep", do_step, S },
    { "fmi2GetStatus", get_status, S | T },
    { "fmi2GetRealStatus", get_real_status, S | T },
    { "fmi2GetBooleanStatus", get_boolean_status, S | T },
    { "fmi2GetStringStatus", get_string_status, S | T },
};
enum { CALL_COUNT = sizeof CALLS / sizeof CALLS[0] };

static const struct {
    enum fmu_phase phase;
    const char *name;
} PHASES[] = { { FMU_INSTANTIATED, "instantiated" },
               { FMU_INITIALIZATION, "initializationMode" },
               { FMU_STEP_COMPLETE, "stepComplete" },
               { FMU_TERMINATED, "terminated" } };

static void refused(const struct fmi2_api *m, fmi2Component c, call *function, const char *name,
                    const char *phase)
{
    struct state_bytes before, after;

    read_state(m, c, &before);
    forget_log();
    CHECK(function(m, c) == fmi2Error);
    CHECK(logged.count == 1 && logged.status == fmi2Error);
    CHECK(log_says(name) && log_says("not allowed in the state") && log_says(phase));
    read_state(m, c, &after);
    CHECK(same_state(&before, &after));
}

static void every_call_in_every_phase(const struct fmi2_api *m)
{
    for (int p = 0; p < 4; p++)
        for (int i = 0; i < CALL_COUNT; i++) {
            fmi2Component c = make_in_phase(m, PHASES[p].phase);
            CHECK(get_state(m, c) == fmi2OK);
            forget_log();
            if (CALLS[i].allowed & PHASES[p].phase) {
                if (!CHECK(CALLS[i].function(m, c) == fmi2OK))
                    fprintf(stderr, "  %s in %s: %s\n", CALLS[i].name, PHASES[p].name, logged.text);
                CHECK(logged.count == 0 || logged.status == fmi2Warning);
            } else
                refused(m, c, CALLS[i].function, CALLS[i].name, PHASES[p].name);
            m->FreeFMUstate(c, &held);
            m->FreeInstance(c);
        }
}

static void output_derivatives(const struct fmi2_api *m)
{
    for (int p = 0; p < 4; p++) {
        fmi2Component c = make_in_phase(m, PHASES[p].phase);
        forget_log();
        CHECK(get_output_derivatives(m, c) == fmi2Error);
        CHECK(log_says("fmi2GetRealOutputDerivatives"));
        CHECK(log_says(p < 2 ? PHASES[p].name : "maxOutputDerivativeOrder is 0"));
        CHECK(m->CancelStep(c) == fmi2Error && log_says("fmi2CancelStep"));
        m->FreeInstance(c);
    }
}

static void null_component(const struct fmi2_api *m)
{
    for (int i = 0; i < CALL_COUNT; i++)
        CHECK(CALLS[i].function(m, NULL) == fmi2Error);
    CHECK(get_output_derivatives(m, NULL) == fmi2Error);
    CHECK(m->CancelStep(NULL) == fmi2Error);
    m->FreeInstance(NULL);
}

static fmi2Component instantiate(const struct fmi2_api *m, const char *name, fmi2Type type, const char *guid)
{
    forget_log();
    return m->Instantiate(name, type, guid, NULL, &CALLBACKS, fmi2False, fmi2False);
}

static void instantiation_refused(const struct fmi2_api *m)
{
    const char *const guids[] = { "",         "{}",
                                  "nonsense", "{00000000-0000-0000-0000-000000000000}",
                                  "{%s%n}",   "{12345678-9abc-def0-1234-56789abcdef01234}" };

    for (size_t i = 0; i < sizeof guids / sizeof guids[0]; i++) {
        CHECK(instantiate(m, "a", fmi2CoSimulation, guids[i]) == NULL);
        CHECK(logged.count == 1 && logged.status == fmi2Error && log_says("GUID") && log_says(guids[i]) &&
              log_says(m->identifier));
    }
    CHECK(instantiate(m, NULL, fmi2CoSimulation, guid_of(m)) == NULL && log_says("name"));
    CHECK(instantiate(m, "", fmi2CoSimulation, guid_of(m)) == NULL && log_says("name"));
    CHECK(instantiate(m, "a", fmi2CoSimulation, NULL) == NULL && log_says("GUID"));
    CHECK(instantiate(m, "a", fmi2ModelExchange, guid_of(m)) == NULL && log_says("co-simulation"));
    CHECK(instantiate(m, "a", fmi2CoSimulation, guid_of(m == &PLANT ? &INVERSE : &PLANT)) == NULL);
    CHECK(m->Instantiate("a", fmi2CoSimulation, "", NULL, NULL, fmi2False, fmi2True) == NULL);
}

static void without_callbacks(const struct fmi2_api *m)
{
    const fmi2CallbackFunctions no_logger = { NULL, NULL, NULL, NULL, NULL };
    const fmi2CallbackFunctions *const callbacks[] = { NULL, &no_logger };

    for (int i = 0; i < 2; i++) {
        fmi2Component c =
            m->Instantiate("a", fmi2CoSimulation, guid_of(m), NULL, callbacks[i], fmi2False, fmi2True);
        CHECK(c != NULL);
        CHECK(m->DoStep(c, 0.0, TS, fmi2True) == fmi2Error);
        CHECK(m->EnterInitializationMode(c) == fmi2OK);
        CHECK(set_real(m, c, "rule[1].sigmaLower", NAN) == fmi2Discard);
        CHECK(m->ExitInitializationMode(c) == fmi2OK);
        CHECK(do_step(m, c) == fmi2OK);
        m->FreeInstance(c);
    }
}

static void setup_refused(const struct fmi2_api *m)
{
    fmi2Component c = make(m);

    CHECK(m->SetupExperiment(c, fmi2False, 0.0, NAN, fmi2False, 0.0) == fmi2Error && log_says("startTime"));
    CHECK(m->SetupExperiment(c, fmi2False, 0.0, 1.0, fmi2True, 0.5) == fmi2Error && log_says("stopTime"));
    CHECK(m->SetupExperiment(c, fmi2False, 0.0, 1.0, fmi2True, NAN) == fmi2Error && log_says("stopTime"));
    CHECK(m->SetupExperiment(c, fmi2True, -1.0, 0.0, fmi2False, 0.0) == fmi2Error && log_says("tolerance"));
    CHECK(m->SetupExperiment(c, fmi2True, NAN, 0.0, fmi2False, 0.0) == fmi2Error && log_says("tolerance"));
    CHECK(m->SetupExperiment(c, fmi2False, NAN, 1.0, fmi2False, NAN) == fmi2OK); /* undefined: not read */
    CHECK(m->SetupExperiment(c, fmi2False, 0.0, 1.0, fmi2True, -INFINITY) == fmi2Error);
    CHECK(m->SetupExperiment(c, fmi2True, 1e-6, 1.0, fmi2True, 1.0) == fmi2OK);
    CHECK(m->SetupExperiment(c, fmi2False, 0.0, 1.0, fmi2True, INFINITY) == fmi2OK); /* as if undefined */
    CHECK(m->EnterInitializationMode(c) == fmi2OK && m->ExitInitializationMode(c) == fmi2OK);
    CHECK(set_real(m, c, input_of(m), signal(m, 0.0)) == fmi2OK);
    CHECK(m->DoStep(c, 1.0, 10.0, fmi2True) == fmi2OK);
    m->FreeInstance(c);
}

/* Outputs along a short run from wherever the instance is initialised. */
static void run(const struct fmi2_api *m, fmi2Component c, double *output, int ticks)
{
    CHECK(m->SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK);
    CHECK(m->EnterInitializationMode(c) == fmi2OK && m->ExitInitializationMode(c) == fmi2OK);
    for (int k = 0; k < ticks; k++) {
        CHECK(set_real(m, c, input_of(m), signal(m, k * TS)) == fmi2OK);
        CHECK(m->DoStep(c, k * TS, TS, fmi2True) == fmi2OK);
        output[k] = get_real(m, c, output_of(m));
    }
}

static void reset_returns_to_the_start(const struct fmi2_api *m)
{
    enum { TICKS = 50 };
    double first[TICKS], second[TICKS];

    for (int p = 0; p < 4; p++) {
        struct state_bytes fresh, again;
        fmi2Component c = make(m);
        read_state(m, c, &fresh);
        run(m, c, first, TICKS);
        m->FreeInstance(c);
        c = make_in_phase(m, PHASES[p].phase);
        set_real(m, c, "rule[1].q1", 0.5);
        set_real(m, c, input_of(m), signal(m, 1.0));
        set_slope(m, c, input_of(m), 1e-3);
        do_step(m, c);
        set_real(m, c, "rule[1].sigmaLower", -1.0); /* so that an end of initialization is refused */
        CHECK(m->ExitInitializationMode(c) == fmi2Error);
        CHECK(m->Reset(c) == fmi2OK);
        read_state(m, c, &again);
        CHECK(same_state(&fresh, &again));
        run(m, c, second, TICKS);
        CHECK(memcmp(first, second, sizeof first) == 0);
        m->FreeInstance(c);
    }
}

static void interleaved_instances(const struct fmi2_api *a, const struct fmi2_api *b)
{
    enum { TICKS = 200 };
    double alone[TICKS], alone_b[TICKS];
    fmi2Component c = make(a), d = make(b);

    run(a, c, alone, TICKS);
    run(b, d, alone_b, TICKS);
    a->FreeInstance(c);
    b->FreeInstance(d);
    c = make_running(a, 0.0);
    d = make_running(b, 0.0);
    for (int k = 0; k < TICKS; k++) {
        CHECK(set_real(a, c, input_of(a), signal(a, k * TS)) == fmi2OK);
        CHECK(set_real(b, d, input_of(b), signal(b, k * TS)) == fmi2OK);
        CHECK(a->DoStep(c, k * TS, TS, fmi2True) == fmi2OK);
        CHECK(b->DoStep(d, k * TS, TS, fmi2True) == fmi2OK);
        CHECK(get_real(a, c, output_of(a)) == alone[k]);
        CHECK(get_real(b, d, output_of(b)) == alone_b[k]);
    }
    /* a parameter of one does not reach the other */
    CHECK(a->Reset(c) == fmi2OK && set_real(a, c, "rule[1].q3", 1e-6) == fmi2OK);
    CHECK(get_real(b, d, "rule[1].q3") == start_parameters()->rule[0].q3);
    a->FreeInstance(c);
    b->FreeInstance(d);
}

/* The inverse in front of the plant: each tick of the plant lands on the reference. */
static void inverse_drives_plant(void)
{
    fmi2Component inverse = make_running(&INVERSE, 0.0), plant = make_running(&PLANT, 0.0);

    for (int k = 0; k < 2000; k++) {
        const double reference = signal(&INVERSE, k * TS);
        CHECK(set_real(&INVERSE, inverse, "reference", reference) == fmi2OK);
        CHECK(INVERSE.DoStep(inverse, k * TS, TS, fmi2True) <= fmi2Warning);
        CHECK(set_real(&PLANT, plant, "voltage", get_real(&INVERSE, inverse, "voltage")) == fmi2OK);
        CHECK(PLANT.DoStep(plant, k * TS, TS, fmi2True) <= fmi2Warning);
        CHECK_CLOSE(get_real(&PLANT, plant, "displacement"), reference, 1e-9);
        CHECK(get_real(&PLANT, plant, "measured") == get_real(&PLANT, plant, "displacement"));
        CHECK(get_boolean(&INVERSE, inverse, "saturated") == 0);
    }
    PLANT.FreeInstance(plant);
    INVERSE.FreeInstance(inverse);
}

static void of_model(const struct fmi2_api *m)
{
    CHECK(strcmp(m->GetVersion(), "2.0") == 0);
    CHECK(strcmp(m->GetTypesPlatform(), "default") == 0);
    every_call_in_every_phase(m);
    output_derivatives(m);
    null_component(m);
    instantiation_refused(m);
    without_callbacks(m);
    setup_refused(m);
    reset_returns_to_the_start(m);
}

/* Found by fuzz_parameters: where a voltage moves next to nothing, (30) may have no finite value. */
static void start_output_not_finite(void)
{
    fmi2Component c = make_initializing(&INVERSE, 0.0);
    const fmi2ValueReference out = reference_of(&INVERSE, "voltage");
    double value = 7.0;

    CHECK(set_real(&INVERSE, c, "rule[1].q2", 2e-314) == fmi2OK);
    CHECK(set_real(&INVERSE, c, "rule[2].q2", 2e-314) == fmi2OK);
    CHECK(set_real(&INVERSE, c, "rule[3].q2", 2e-314) == fmi2OK);
    CHECK(set_real(&INVERSE, c, "initialDisplacement", 79e-6) == fmi2OK);
    CHECK(INVERSE.GetReal(c, &out, 1, &value) == fmi2Error);
    CHECK(log_says("finite"));
    CHECK(INVERSE.ExitInitializationMode(c) == fmi2Error && value == 7.0);
    CHECK(set_real(&INVERSE, c, "initialDisplacement", 1e-6) == fmi2OK);
    CHECK(INVERSE.ExitInitializationMode(c) == fmi2OK);
    INVERSE.FreeInstance(c);
}

int main(void)
{
    of_model(&PLANT);
    of_model(&INVERSE);
    interleaved_instances(&PLANT, &PLANT);
    interleaved_instances(&PLANT, &INVERSE);
    interleaved_instances(&INVERSE, &INVERSE);
    inverse_drives_plant();
    start_output_not_finite();
    return check_report("fmi2 lifecycle");
}
