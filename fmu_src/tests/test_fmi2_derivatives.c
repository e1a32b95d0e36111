/* Directional derivatives: those of the last doStep, and in initialization those of the start. */
#include "fmi2_fixture.h"

CHECK_MAIN;

static double derivative(const struct fmi2_api *m, fmi2Component c, const char *known)
{
    const fmi2ValueReference unknown = reference_of(m, output_of(m)), r = reference_of(m, known);
    const double seed = 1.0;
    double value = NAN;

    CHECK(m->GetDirectionalDerivative(c, &unknown, 1, &r, 1, &seed, &value) == fmi2OK);
    return value;
}

/* The output of a step of h from `state` with the input moved by d. */
static double repeat(const struct fmi2_api *m, fmi2Component c, fmi2FMUstate state, double input, double time,
                     double h)
{
    CHECK(m->SetFMUstate(c, state) == fmi2OK);
    CHECK(set_real(m, c, input_of(m), input) == fmi2OK);
    CHECK(m->DoStep(c, time, h, fmi2True) <= fmi2Warning);
    return get_real(m, c, output_of(m));
}

static void of_step(const struct fmi2_api *m, double h, double slope)
{
    const double time = 40 * TS;
    const double input = signal(m, time);
    const double d = m == &PLANT ? 1e-2 : 1e-10;
    fmi2Component c = make_running(m, 0.0);
    fmi2FMUstate state = NULL;

    CHECK(set_real(m, c, input_of(m), input) == fmi2OK);
    CHECK(m->DoStep(c, 0.0, time, fmi2True) <= fmi2Warning);
    CHECK(set_slope(m, c, input_of(m), slope) == fmi2OK);
    CHECK(m->GetFMUstate(c, &state) == fmi2OK);
    const double up = repeat(m, c, state, input + d, time, h);
    const double down = repeat(m, c, state, input - d, time, h);
    repeat(m, c, state, input, time, h);
    struct state_bytes before, after;
    read_state(m, c, &before);
    const double value = derivative(m, c, input_of(m));
    const double difference = (up - down) / (2.0 * d);
    CHECK_NEAR(value, difference, difference, 1e-6);
    CHECK(derivative(m, c, "force") == 0.0 && derivative(m, c, "temperature") == 0.0);
    read_state(m, c, &after);
    CHECK(same_state(&before, &after)); /* asking changes nothing */
    CHECK(m->SetFMUstate(c, state) == fmi2OK);
    m->FreeFMUstate(c, &state);
    m->FreeInstance(c);
}

static void no_tick(const struct fmi2_api *m)
{
    fmi2Component c = make_running(m, 0.0);

    CHECK(derivative(m, c, input_of(m)) == 0.0); /* before the first step */
    CHECK(set_real(m, c, input_of(m), signal(m, 0.0)) == fmi2OK);
    CHECK(m->DoStep(c, 0.0, 0.5 * TS, fmi2True) <= fmi2Warning);
    CHECK(derivative(m, c, input_of(m)) != 0.0);
    CHECK(m->DoStep(c, 0.5 * TS, 0.25 * TS, fmi2True) == fmi2OK);
    CHECK(derivative(m, c, input_of(m)) == 0.0);
    CHECK(m->DoStep(c, 0.75 * TS, TS, fmi2True) == fmi2OK);
    const double before = derivative(m, c, input_of(m));
    CHECK(before != 0.0);
    CHECK(m->Terminate(c) == fmi2OK && derivative(m, c, input_of(m)) == before);
    m->FreeInstance(c);
}

/* A seed that is given twice counts twice; all outputs at once; both outputs of the plant agree. */
static void several_at_once(void)
{
    fmi2Component c = make_running(&PLANT, 0.0);
    const fmi2ValueReference unknowns[] = { reference_of(&PLANT, "measured"),
                                            reference_of(&PLANT, "displacement") };
    const fmi2ValueReference knowns[] = { reference_of(&PLANT, "voltage"), reference_of(&PLANT, "force"),
                                          reference_of(&PLANT, "voltage") };
    const double seeds[] = { 2.0, 5.0, -0.5 };
    double values[2] = { 0.0, 0.0 };

    CHECK(set_real(&PLANT, c, "voltage", 50.0) == fmi2OK);
    CHECK(PLANT.DoStep(c, 0.0, TS, fmi2True) == fmi2OK);
    CHECK(PLANT.GetDirectionalDerivative(c, unknowns, 2, knowns, 3, seeds, values) == fmi2OK);
    CHECK_CLOSE(values[0], 1.5 * derivative(&PLANT, c, "voltage"), 1e-14);
    CHECK(values[0] == values[1]);
    PLANT.FreeInstance(c);
}

static void refused(const struct fmi2_api *m)
{
    fmi2Component c = make_running(m, 0.0);
    const fmi2ValueReference output = reference_of(m, output_of(m)), input = reference_of(m, input_of(m));
    const fmi2ValueReference parameter = reference_of(m, "rule[1].q1"), count = reference_of(m, "ruleCount");
    const fmi2ValueReference unknown = 1000;
    const double seed = 1.0;
    double value = 3.0;

    CHECK(m->GetDirectionalDerivative(c, &output, 1, &parameter, 1, &seed, &value) == fmi2Error);
    CHECK(log_says("rule[1].q1"));
    CHECK(m->GetDirectionalDerivative(c, &output, 1, &output, 1, &seed, &value) == fmi2Error);
    CHECK(m->GetDirectionalDerivative(c, &input, 1, &input, 1, &seed, &value) == fmi2Error);
    CHECK(log_says(input_of(m)) && log_says("not an unknown"));
    CHECK(m->GetDirectionalDerivative(c, &unknown, 1, &input, 1, &seed, &value) == fmi2Error);
    CHECK(m->GetDirectionalDerivative(c, &output, 1, &unknown, 1, &seed, &value) == fmi2Error);
    CHECK(m->GetDirectionalDerivative(c, NULL, 1, &input, 1, &seed, &value) == fmi2Error && log_says("null"));
    CHECK(m->GetDirectionalDerivative(c, &output, 1, NULL, 1, &seed, &value) == fmi2Error);
    CHECK(m->GetDirectionalDerivative(c, &output, 1, &input, 1, NULL, &value) == fmi2Error);
    CHECK(m->GetDirectionalDerivative(c, &output, 1, &input, 1, &seed, NULL) == fmi2Error);
    CHECK(m->GetDirectionalDerivative(c, NULL, 0, NULL, 0, NULL, NULL) == fmi2OK);
    m->FreeInstance(c);
    c = make_initializing(m, 0.0);
    CHECK(m->GetDirectionalDerivative(c, &output, 1, &count, 1, &seed, &value) == fmi2Error);
    CHECK(log_says("ruleCount"));
    CHECK(value == 3.0);
    if (m == &INVERSE) {
        const fmi2ValueReference saturated = reference_of(m, "saturated");
        CHECK(m->GetDirectionalDerivative(c, &saturated, 1, &input, 1, &seed, &value) == fmi2Error);
    }
    CHECK(set_real(m, c, "rule[1].q1", 5.0) == fmi2OK); /* unusable: the start is not defined */
    CHECK(m->GetDirectionalDerivative(c, &output, 1, &parameter, 1, &seed, &value) == fmi2Error);
    m->FreeInstance(c);
}

static double start_output(const struct fmi2_api *m, fmi2Component c, const char *name, double value)
{
    CHECK(set_real(m, c, name, value) == fmi2OK);
    return get_real(m, c, output_of(m));
}

static void of_start(const struct fmi2_api *m)
{
    static const char *const fields[] = { "sigmaLower", "sigmaUpper", "centre", "q1", "q2", "q3" };
    fmi2Component c = make_initializing(m, 0.0);
    const double at = 6e-6;
    const double d = 1e-10;

    CHECK(set_real(m, c, "initialDisplacement", at) == fmi2OK);
    const double slope = (start_output(m, c, "initialDisplacement", at + d) -
                          start_output(m, c, "initialDisplacement", at - d)) /
                         (2.0 * d);
    CHECK(set_real(m, c, "initialDisplacement", at) == fmi2OK);
    CHECK_NEAR(derivative(m, c, "initialDisplacement"), slope, slope, 1e-6);
    CHECK(derivative(m, c, "sampleTime") == 0.0 && derivative(m, c, "voltageMin") == 0.0);
    CHECK(derivative(m, c, input_of(m)) == 0.0);
    for (int l = 1; l <= 3; l++)
        for (int i = 0; i < 6; i++) {
            char name[32];
            snprintf(name, sizeof name, "rule[%d].%s", l, fields[i]);
            const double value = get_real(m, c, name);
            const double h = 1e-5 * fabs(value);
            const double difference =
                (start_output(m, c, name, value + h) - start_output(m, c, name, value - h)) / (2.0 * h);
            CHECK(set_real(m, c, name, value) == fmi2OK);
            CHECK_NEAR(derivative(m, c, name), difference, fmax(fabs(difference), 1e-3 / fabs(value)), 1e-5);
        }
    CHECK(derivative(m, c, "rule[7].q1") == 0.0); /* not in use */
    m->FreeInstance(c);
}

static void of_model(const struct fmi2_api *m)
{
    const double slope = m == &PLANT ? 300.0 : 5e-5;

    of_step(m, TS, 0.0);
    of_step(m, 100 * TS, 0.0);
    of_step(m, TS, slope);
    of_step(m, 7.3 * TS, slope);
    of_step(m, 100 * TS, slope);
    no_tick(m);
    refused(m);
    of_start(m);
}

/* Found by fuzz_calls: seeds so large that the derivative overflows. */
static void seeds_overflow(const struct fmi2_api *m)
{
    fmi2Component c = make_running(m, 0.0);
    const fmi2ValueReference in = reference_of(m, input_of(m)), out = reference_of(m, output_of(m));
    const fmi2ValueReference twice[] = { in, in };
    const double seeds[] = { 1.7e308, 1.7e308 };
    double value = 7.0;

    CHECK(set_real(m, c, input_of(m), signal(m, 0.0)) == fmi2OK);
    CHECK(m->DoStep(c, 0.0, TS, fmi2True) <= fmi2Warning);
    CHECK(m->GetDirectionalDerivative(c, &out, 1, twice, 2, seeds, &value) == fmi2Discard);
    CHECK(log_says("finite") && value == 7.0);
    m->FreeInstance(c);
}

/* A derivative repeats the last step: what a state claims of it must not keep a host waiting. */
static void endless_step(const struct fmi2_api *m)
{
    enum { HEADER = 40, CHECKSUM = 32 };
    const fmi2ValueReference in = reference_of(m, input_of(m)), out = reference_of(m, output_of(m));
    const double seed = 1.0;
    double value = 7.0;
    fmi2Component c = make_running(m, 0.0);
    fmi2FMUstate state = NULL;
    struct state_bytes bytes;
    struct block snapshot;

    CHECK(set_real(m, c, input_of(m), signal(m, 0.0)) == fmi2OK);
    CHECK(m->DoStep(c, 0.0, TS, fmi2True) <= fmi2Warning);
    read_state(m, c, &bytes);
    memcpy(&snapshot, bytes.byte + HEADER, sizeof snapshot);
    snapshot.s.one_tick = 0; /* as many as a step can have, all in their place */
    snapshot.s.last_step.end_tick = snapshot.s.clock.next_tick;
    snapshot.s.last_step.tick = snapshot.s.last_step.first_tick = snapshot.s.clock.next_tick - 1000000001;
    const uint64_t checksum = fmu_hash(&snapshot, sizeof snapshot);
    memcpy(bytes.byte + CHECKSUM, &checksum, sizeof checksum);
    memcpy(bytes.byte + HEADER, &snapshot, sizeof snapshot);
    CHECK(m->DeSerializeFMUstate(c, bytes.byte, bytes.size, &state) == fmi2OK);
    CHECK(m->SetFMUstate(c, state) == fmi2OK);
    CHECK(m->GetDirectionalDerivative(c, &out, 1, &in, 1, &seed, &value) == fmi2Discard);
    CHECK(log_says("more than 1000000 ticks") && value == 7.0);
    CHECK(m->DoStep(c, TS, TS, fmi2True) <= fmi2Warning); /* and then it is as good as any */
    CHECK(isfinite(derivative(m, c, input_of(m))));
    m->FreeFMUstate(c, &state);
    m->FreeInstance(c);
}

/* The longest step with a derivative, and one tick more. */
static void longest_step(const struct fmi2_api *m)
{
    const fmi2ValueReference in = reference_of(m, input_of(m)), out = reference_of(m, output_of(m));
    const double seed = 1.0;
    double value = 7.0;
    fmi2Component c = make_running(m, 0.0);

    CHECK(set_real(m, c, input_of(m), signal(m, 0.0)) == fmi2OK);
    CHECK(m->DoStep(c, 0.0, 100.0, fmi2True) <= fmi2Warning);
    CHECK(isfinite(derivative(m, c, input_of(m))));
    CHECK(m->DoStep(c, 100.0, 100.0 + TS, fmi2True) <= fmi2Warning);
    CHECK(m->GetDirectionalDerivative(c, &out, 1, &in, 1, &seed, &value) == fmi2Discard && value == 7.0);
    m->FreeInstance(c);
}

/* Of one tick and nothing of the steps before, whichever they were, and however time is cut afterwards. */
static void after_a_ramp(const struct fmi2_api *m)
{
    fmi2Component by_steps = make_running(m, 0.0), by_ticks = make_running(m, 0.0);
    const double value = signal(m, 0.0), slope = m == &PLANT ? 300.0 : 5e-5;

    CHECK(set_real(m, by_steps, input_of(m), value) == fmi2OK);
    CHECK(set_slope(m, by_steps, input_of(m), slope) == fmi2OK);
    CHECK(m->DoStep(by_steps, 0.0, 5 * TS, fmi2True) <= fmi2Warning);
    for (int k = 0; k < 5; k++) {
        CHECK(set_real(m, by_ticks, input_of(m), value + slope * k * TS) == fmi2OK);
        CHECK(m->DoStep(by_ticks, k * TS, TS, fmi2True) <= fmi2Warning);
    }
    CHECK(set_slope(m, by_steps, input_of(m), 0.0) == fmi2OK);
    for (int k = 5; k < 7; k++) {
        CHECK(set_real(m, by_steps, input_of(m), value) == fmi2OK);
        CHECK(set_real(m, by_ticks, input_of(m), value) == fmi2OK);
        CHECK(m->DoStep(by_steps, k * TS, k == 5 ? TS : 0.5 * TS, fmi2True) <= fmi2Warning);
        CHECK(m->DoStep(by_ticks, k * TS, TS, fmi2True) <= fmi2Warning);
        const double expected = derivative(m, by_ticks, input_of(m));
        CHECK(expected != 0.0);
        CHECK_NEAR(derivative(m, by_steps, input_of(m)), expected, expected, 1e-12);
    }
    m->FreeInstance(by_steps);
    m->FreeInstance(by_ticks);
}

int main(void)
{
    of_model(&PLANT);
    of_model(&INVERSE);
    after_a_ramp(&PLANT);
    after_a_ramp(&INVERSE);
    several_at_once();
    seeds_overflow(&PLANT);
    seeds_overflow(&INVERSE);
    endless_step(&PLANT);
    endless_step(&INVERSE);
    longest_step(&PLANT);
    return check_report("fmi2 derivatives");
}
