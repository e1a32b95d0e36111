/* Get and set by value reference: what is refused, that nothing changes then, unusable parameters. */
#include "fmi2_fixture.h"

CHECK_MAIN;

static const fmi2ValueReference UNKNOWN[] = { 900, 1000, 4294967295u };

static void unknown_references(const struct fmi2_api *m)
{
    fmi2Component c = make_running(m, 0.0);
    double real = 1.0;
    int integer = 1;
    fmi2String string = "";

    for (int i = 0; i < 3; i++) {
        const fmi2ValueReference *r = &UNKNOWN[i];
        char number[16];
        snprintf(number, sizeof number, "%u", *r);
        CHECK(m->GetReal(c, r, 1, &real) == fmi2Error && log_says(number) && log_says("fmi2GetReal"));
        CHECK(m->SetReal(c, r, 1, &real) == fmi2Error && log_says(number) && log_says("fmi2SetReal"));
        CHECK(m->GetInteger(c, r, 1, &integer) == fmi2Error && log_says(number));
        CHECK(m->SetInteger(c, r, 1, &integer) == fmi2Error && log_says(number));
        CHECK(m->GetBoolean(c, r, 1, &integer) == fmi2Error && log_says(number));
        CHECK(m->SetBoolean(c, r, 1, &integer) == fmi2Error && log_says(number));
        CHECK(m->GetString(c, r, 1, &string) == fmi2Error && log_says(number));
        CHECK(m->SetString(c, r, 1, &string) == fmi2Error && log_says(number));
    }
    /* the other model's variables are in the table, but not in this FMU */
    const struct fmi2_api *other = m == &PLANT ? &INVERSE : &PLANT;
    const fmi2ValueReference foreign = reference_of(other, input_of(other));
    CHECK(m->SetReal(c, &foreign, 1, &real) == fmi2Error && log_says(m->identifier));
    m->FreeInstance(c);
}

static void wrong_types(const struct fmi2_api *m)
{
    fmi2Component c = make_initializing(m, 0.0);
    const fmi2ValueReference a_real = reference_of(m, "rule[1].q1");
    const fmi2ValueReference an_integer = reference_of(m, "ruleCount");
    double real = 3.0;
    int integer = 3;
    fmi2String string = "3";

    CHECK(m->GetInteger(c, &a_real, 1, &integer) == fmi2Error);
    CHECK(log_says("rule[1].q1") && log_says("Real") && log_says("Integer"));
    CHECK(m->SetInteger(c, &a_real, 1, &integer) == fmi2Error && log_says("rule[1].q1"));
    CHECK(m->GetReal(c, &an_integer, 1, &real) == fmi2Error && log_says("ruleCount"));
    CHECK(m->SetReal(c, &an_integer, 1, &real) == fmi2Error && log_says("ruleCount"));
    CHECK(m->GetBoolean(c, &an_integer, 1, &integer) == fmi2Error && log_says("Boolean"));
    CHECK(m->SetBoolean(c, &an_integer, 1, &integer) == fmi2Error && log_says("Boolean"));
    CHECK(m->GetString(c, &an_integer, 1, &string) == fmi2Error && log_says("String"));
    CHECK(m->SetString(c, &an_integer, 1, &string) == fmi2Error && log_says("String"));
    CHECK(integer == 3 && real == 3.0);
    m->FreeInstance(c);
}

static void null_arrays(const struct fmi2_api *m)
{
    fmi2Component c = make_running(m, 0.0);
    const fmi2ValueReference r = reference_of(m, input_of(m));
    const fmi2Integer order = 1;
    double value = 1.0;

    CHECK(m->GetReal(c, NULL, 1, &value) == fmi2Error && log_says("null"));
    CHECK(m->GetReal(c, &r, 1, NULL) == fmi2Error && log_says("null"));
    CHECK(m->SetReal(c, NULL, 1, &value) == fmi2Error && log_says("null"));
    CHECK(m->SetReal(c, &r, 1, NULL) == fmi2Error && log_says("null"));
    CHECK(m->GetReal(c, NULL, 0, NULL) == fmi2OK);
    CHECK(m->SetReal(c, NULL, 0, NULL) == fmi2OK);
    CHECK(m->SetRealInputDerivatives(c, NULL, 1, &order, &value) == fmi2Error && log_says("null"));
    CHECK(m->SetRealInputDerivatives(c, &r, 1, NULL, &value) == fmi2Error && log_says("null"));
    CHECK(m->SetRealInputDerivatives(c, &r, 1, &order, NULL) == fmi2Error && log_says("null"));
    CHECK(m->SetRealInputDerivatives(c, NULL, 0, NULL, NULL) == fmi2OK);
    CHECK(m->GetStatus(c, fmi2DoStepStatus, NULL) == fmi2Error && log_says("null"));
    CHECK(m->GetRealStatus(c, fmi2LastSuccessfulTime, NULL) == fmi2Error && log_says("null"));
    m->FreeInstance(c);
}

static void outputs_and_parameters(const struct fmi2_api *m)
{
    fmi2Component c = make_initializing(m, 0.0);
    const double start = get_real(m, c, output_of(m));

    CHECK(set_real(m, c, output_of(m), 1.0) == fmi2Error && log_says("output") && log_says(output_of(m)));
    CHECK(get_real(m, c, output_of(m)) == start);
    CHECK(m->ExitInitializationMode(c) == fmi2OK);
    CHECK(set_real(m, c, output_of(m), 1.0) == fmi2Error && log_says("output"));
    CHECK(set_real(m, c, "rule[2].q1", 0.9) == fmi2Error);
    CHECK(log_says("rule[2].q1") && log_says("before initialization ends"));
    CHECK(set_integer(m, c, "ruleCount", 2) == fmi2Error && log_says("ruleCount"));
    CHECK(get_real(m, c, "rule[2].q1") == start_parameters()->rule[1].q1);
    CHECK(get_integer(m, c, "ruleCount") == 3);
    if (m == &INVERSE) {
        const fmi2ValueReference r = reference_of(m, "saturated");
        const fmi2Boolean yes = fmi2True;
        CHECK(m->SetBoolean(c, &r, 1, &yes) == fmi2Error && log_says("saturated"));
    }
    m->FreeInstance(c);
}

/* All of a call's values are checked before any is set. */
static void all_or_nothing(const struct fmi2_api *m)
{
    fmi2Component c = make_running(m, 0.0);
    const double old = get_real(m, c, input_of(m));
    const fmi2ValueReference bad_last[] = { reference_of(m, input_of(m)), reference_of(m, "force"), 1000 };
    const double values[] = { signal(m, 0.1), 2.0, 3.0 };
    const double not_finite[] = { signal(m, 0.1), NAN };

    CHECK(m->SetReal(c, bad_last, 3, values) == fmi2Error);
    CHECK(get_real(m, c, input_of(m)) == old && get_real(m, c, "force") == 0.0);
    CHECK(m->SetReal(c, bad_last, 2, not_finite) == fmi2Discard);
    CHECK(get_real(m, c, input_of(m)) == old);
    CHECK(m->SetReal(c, bad_last, 2, values) == fmi2OK);
    CHECK(get_real(m, c, input_of(m)) == values[0] && get_real(m, c, "force") == 2.0);
    m->FreeInstance(c);
}

static void not_finite(const struct fmi2_api *m)
{
    const double bad[] = { NAN, INFINITY, -INFINITY };
    fmi2Component c = make_running(m, 0.0);
    const double good = signal(m, 0.0);

    CHECK(set_real(m, c, input_of(m), good) == fmi2OK);
    for (int i = 0; i < 3; i++) {
        forget_log();
        CHECK(set_real(m, c, input_of(m), bad[i]) == fmi2Discard);
        CHECK(logged.status == fmi2Discard && log_says(input_of(m)) && log_says("finite"));
        CHECK(strcmp(logged.category, "logStatusDiscard") == 0);
        CHECK(get_real(m, c, input_of(m)) == good);
        CHECK(set_slope(m, c, input_of(m), bad[i]) == fmi2Discard && log_says(input_of(m)));
    }
    CHECK(m->DoStep(c, 0.0, TS, fmi2True) == fmi2OK);
    CHECK(isfinite(get_real(m, c, output_of(m))));
    m->FreeInstance(c);
}

static void input_derivatives(const struct fmi2_api *m)
{
    fmi2Component c = make_running(m, 0.0);
    const fmi2ValueReference input = reference_of(m, input_of(m));
    const fmi2ValueReference output = reference_of(m, output_of(m));
    const fmi2ValueReference parameter = reference_of(m, "rule[1].q1");
    const fmi2Integer orders[] = { 1, 2, 0, -1 };
    const double value = 1.0;

    CHECK(m->SetRealInputDerivatives(c, &input, 1, &orders[0], &value) == fmi2OK);
    for (int i = 1; i < 4; i++)
        CHECK(m->SetRealInputDerivatives(c, &input, 1, &orders[i], &value) == fmi2Error && log_says("order"));
    CHECK(m->SetRealInputDerivatives(c, &output, 1, orders, &value) == fmi2Error && log_says("not an input"));
    CHECK(m->SetRealInputDerivatives(c, &parameter, 1, orders, &value) == fmi2Error);
    CHECK(log_says("rule[1].q1"));
    CHECK(m->SetRealInputDerivatives(c, &UNKNOWN[0], 1, orders, &value) == fmi2Error);
    m->FreeInstance(c);
}

/* Parameters that make no usable model: named at the end of initialisation; mended, it goes on. */
static void unusable_parameters(const struct fmi2_api *m)
{
    static const struct {
        const char *name;
        double value;
        const char *culprit;
    } CASES[] = {
        { "sampleTime", 0.0, "sampleTime" },
        { "sampleTime", -1e-4, "sampleTime" },
        { "rule[1].sigmaLower", 0.0, "rule[1].sigmaLower" },
        { "rule[2].sigmaLower", -1e-6, "rule[2].sigmaLower" },
        { "rule[3].sigmaUpper", 1e-6, "rule[3].sigmaUpper" },
        { "rule[2].centre", 1.0, "rule[2].centre" },
        { "rule[2].q1", 1.3, "contraction" },
        { "rule[1].q1", 11.0, "rule[1].q1" },
        { "rule[2].q2", -1e-6, "q2" },
        { "displacementMax", 0.0, "displacementMax" },
        { "displacementMax", 2e-5, "contraction" },
        { "displacementMin", 1.7e-5, "displacementMin" },
        { "voltageMax", 0.0, "voltageMax" },
        { "voltageMin", 200.0, "voltageMin" },
        { "initialDisplacement", 1.0, "initialDisplacement" },
    };

    for (size_t i = 0; i < sizeof CASES / sizeof CASES[0]; i++) {
        fmi2Component c = make_initializing(m, 0.0);
        const fmi2ValueReference output = reference_of(m, output_of(m));
        const double good = get_real(m, c, CASES[i].name);
        double value = -7.0;
        CHECK(set_real(m, c, CASES[i].name, CASES[i].value) == fmi2OK);
        forget_log();
        CHECK(m->GetReal(c, &output, 1, &value) == fmi2Error && log_says(CASES[i].culprit));
        CHECK(m->ExitInitializationMode(c) == fmi2Error);
        CHECK(logged.status == fmi2Error && log_says("fmi2ExitInitializationMode"));
        CHECK(log_says(CASES[i].culprit));
        CHECK(m->DoStep(c, 0.0, TS, fmi2True) == fmi2Error && log_says("initializationMode"));
        CHECK(set_real(m, c, CASES[i].name, good) == fmi2OK);
        CHECK(m->ExitInitializationMode(c) == fmi2OK);
        CHECK(set_real(m, c, input_of(m), signal(m, 0.0)) == fmi2OK);
        CHECK(m->DoStep(c, 0.0, TS, fmi2True) <= fmi2Warning);
        m->FreeInstance(c);
    }
}

/* Counts are those of the set that the FMU was packaged with, or fewer. */
static void counts(const struct fmi2_api *m)
{
    static const struct {
        const char *name;
        int bad;
        const char *reason;
    } CASES[] = {
        { "ruleCount", 0, "must be 1 to 3" },   { "ruleCount", -2147483647 - 1, "must be 1 to 3" },
        { "ruleCount", 4, "packaged with 3" },  { "ruleCount", 2147483647, "packaged with 3" },
        { "playCount", 2, "packaged with 0" },  { "playCount", -1, "must be 0" },
        { "creepCount", 1, "packaged with 0" }, { "creepCount", -1, "must be 0" },
    };
    fmi2Component c = make(m);

    for (int phase = 0; phase < 2; phase++) {
        for (size_t i = 0; i < sizeof CASES / sizeof CASES[0]; i++) {
            const int before = start_parameters()->ruleCount;
            CHECK(set_integer(m, c, CASES[i].name, CASES[i].bad) == fmi2Error);
            CHECK(log_says(CASES[i].name) && log_says(CASES[i].reason));
            CHECK(phase == 0 || get_integer(m, c, "ruleCount") == before);
        }
        CHECK(set_integer(m, c, "ruleCount", 3) == fmi2OK && set_integer(m, c, "playCount", 0) == fmi2OK);
        CHECK(set_integer(m, c, "creepCount", 0) == fmi2OK);
        if (phase == 0)
            CHECK(m->EnterInitializationMode(c) == fmi2OK);
    }
    CHECK(set_integer(m, c, "ruleCount", 2) == fmi2OK); /* rules beyond the count do not matter */
    CHECK(set_real(m, c, "rule[3].sigmaLower", -1.0) == fmi2OK);
    CHECK(m->ExitInitializationMode(c) == fmi2OK && get_integer(m, c, "ruleCount") == 2);
    CHECK(m->Reset(c) == fmi2OK && set_integer(m, c, "ruleCount", 3) == fmi2OK); /* and back */
    m->FreeInstance(c);
}

/* With the count lowered, the model is that of the rules that are left. */
static void fewer_rules_than_packaged(void)
{
    static struct it2_table table;
    struct it2 core;
    struct it2_state state;
    fmi2Component c = make_initializing(&PLANT, 0.0);
    long wrong = 0;

    CHECK(set_integer(&PLANT, c, "ruleCount", 2) == fmi2OK);
    CHECK(PLANT.ExitInitializationMode(c) == fmi2OK);
    it2_prepare(&core, start_parameters()->rule, 2,
                (struct it2_range){ start_parameters()->displacementMin, start_parameters()->displacementMax });
    CHECK(it2_tabulate(&core, &table));
    it2_reset(&state, start_parameters()->initialDisplacement);
    for (int k = 0; k < 1000; k++) {
        const double voltage = 30.0 + 20.0 * sin(0.01 * k);
        CHECK(set_real(&PLANT, c, "voltage", voltage) == fmi2OK);
        CHECK(PLANT.DoStep(c, k * TS, TS, fmi2True) <= fmi2Warning);
        wrong += get_real(&PLANT, c, "displacement") != it2_step(&core, &state, voltage);
    }
    CHECK(wrong == 0);
    PLANT.FreeInstance(c);
}

static void start_values(const struct fmi2_api *m)
{
    fmi2Component c = make_initializing(m, 0.0);

    CHECK(get_real(m, c, "sampleTime") == TS);
    CHECK(get_real(m, c, "rule[1].sigmaLower") == 4.3427e-6);
    CHECK(get_real(m, c, "rule[3].q3") == -6.2312e-6);
    CHECK(get_real(m, c, "temperature") == 293.15);
    CHECK(get_real(m, c, "force") == 0.0);
    CHECK(get_real(m, c, input_of(m)) == 0.0);
    CHECK(set_real(m, c, "initialDisplacement", 5e-6) == fmi2OK);
    if (m == &PLANT)
        CHECK(get_real(m, c, "displacement") == 5e-6 && get_real(m, c, "measured") == 5e-6);
    const double hold = get_real(m, c, output_of(m));
    CHECK(m->ExitInitializationMode(c) == fmi2OK);
    CHECK(get_real(m, c, output_of(m)) == hold);
    m->FreeInstance(c);
}

/* The inverse starts with the voltage that holds the plant where it is. */
static void inverse_starts_at_rest(void)
{
    fmi2Component inverse = make_initializing(&INVERSE, 0.0), plant = make_initializing(&PLANT, 0.0);

    CHECK(set_real(&INVERSE, inverse, "initialDisplacement", 5e-6) == fmi2OK);
    CHECK(set_real(&PLANT, plant, "initialDisplacement", 5e-6) == fmi2OK);
    CHECK(set_real(&PLANT, plant, "voltage", get_real(&INVERSE, inverse, "voltage")) == fmi2OK);
    CHECK(PLANT.ExitInitializationMode(plant) == fmi2OK);
    CHECK(PLANT.DoStep(plant, 0.0, 100 * TS, fmi2True) == fmi2OK);
    CHECK_CLOSE(get_real(&PLANT, plant, "displacement"), 5e-6, 1e-9);
    PLANT.FreeInstance(plant);
    INVERSE.FreeInstance(inverse);
}

static void of_model(const struct fmi2_api *m)
{
    unknown_references(m);
    wrong_types(m);
    null_arrays(m);
    outputs_and_parameters(m);
    all_or_nothing(m);
    not_finite(m);
    input_derivatives(m);
    unusable_parameters(m);
    counts(m);
    start_values(m);
}

int main(void)
{
    of_model(&PLANT);
    of_model(&INVERSE);
    fewer_rules_than_packaged();
    inverse_starts_at_rest();
    return check_report("fmi2 variables");
}
