/* Ticks are counted, never lost or doubled, and do not depend on how the master cuts time. */
#include "fmi2_fixture.h"

CHECK_MAIN;

/* A signal that is linear between knots Ts * 1000 apart, so that slopes say all of it. */
static double ramp(const struct fmi2_api *m)
{
    return m->kind == FMU_PLANT ? 1000.0 : 1.5e-4; /* per second */
}

/* Runs `ticks` ticks in steps of `step`; out[k] is the output after tick k where it was visible. */
static void run_in_steps(const struct fmi2_api *m, double step, int ticks, double *out)
{
    fmi2Component c = make_running(m, 0.0);
    int seen = 0; /* ticks before the communication point */
    double end = 0.0;

    for (int k = 0; k < ticks; k++)
        out[k] = NAN;
    CHECK(set_slope(m, c, input_of(m), ramp(m)) == fmi2OK);
    for (int n = 0; seen < ticks; n++) {
        const double begin = n * step;
        end = (n + 1) * step;
        CHECK(set_real(m, c, input_of(m), ramp(m) * begin) == fmi2OK);
        CHECK(m->DoStep(c, begin, end - begin, fmi2True) <= fmi2Warning);
        while (seen < ticks && seen * TS < end - 1e-3 * TS)
            seen++;
        if (seen > 0 && seen * TS >= end - 1e-3 * TS)
            out[seen - 1] = get_real(m, c, output_of(m));
    }
    m->FreeInstance(c);
}

static void any_step_same_ticks(const struct fmi2_api *m)
{
    enum { TICKS = 1000 };
    const double steps[] = { TS / 3.0, 7.3 * TS, 100.0 * TS, 0.9 * TS, 1000.0 * TS };
    static double reference[TICKS], out[TICKS];

    run_in_steps(m, TS, TICKS, reference);
    for (int k = 0; k < TICKS; k++)
        CHECK(isfinite(reference[k]));
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        int visible = 0;
        run_in_steps(m, steps[i], TICKS, out);
        for (int k = 0; k < TICKS; k++)
            if (!isnan(out[k])) {
                visible++;
                CHECK_CLOSE(out[k], reference[k], 1e-12);
            }
        CHECK(visible >= 1);
    }
}

/* Under an input that is held, the ticks of a long step are those of short ones, bit for bit, whether they find
 * something or not: within the ranges, beyond them, on the way out and on the way back. */
static void held_input_same_ticks(const struct fmi2_api *m)
{
    static const double volts[] = { 50.0, 109.0, 111.0, 135.0, 60.0, -0.5, -40.0, 20.0, 0.0, 110.0 };
    static const double um[] = { 5.0, 15.9, 16.0, 17.0, 7.0, 0.01, -3.0, 0.0, 4.0, 9.0 };
    static const int lengths[] = { 1, 2, 3, 17, 100, 1000 };
    const char *flag = m->kind == FMU_PLANT ? "outOfRange" : "saturated";
    fmi2Component a = make_running(m, 0.0), b = make_running(m, 0.0);
    int tick = 0, raised = 0, turns = 0;

    for (size_t i = 0; i < 60; i++) {
        const double input = m->kind == FMU_PLANT ? volts[i % 10] : 1e-6 * um[i % 10];
        const int length = lengths[i % 6];
        CHECK(set_real(m, a, input_of(m), input) == fmi2OK && set_real(m, b, input_of(m), input) == fmi2OK);
        for (int k = 0; k < length; k++)
            CHECK(m->DoStep(a, (tick + k) * TS, TS, fmi2True) <= fmi2Warning);
        CHECK(m->DoStep(b, tick * TS, length * TS, fmi2True) <= fmi2Warning);
        tick += length;
        CHECK(get_real(m, a, output_of(m)) == get_real(m, b, output_of(m)));
        CHECK(get_boolean(m, a, flag) == get_boolean(m, b, flag));
        raised += get_boolean(m, b, flag);
        turns++;
    }
    CHECK(raised > 5 && raised < turns - 5);
    m->FreeInstance(a);
    m->FreeInstance(b);
}

/* The input at each tick is the one at its own time: voltage = time, seen by the counting model. */
static void ticks_see_their_own_time(double start, double step, int steps)
{
    fmi2Component c = make_running(&COUNTING, start);
    const long first = (long)ceil(start / TS - 1e-6);

    counting_ticks = 0;
    CHECK(set_slope(&COUNTING, c, "voltage", 1.0) == fmi2OK);
    for (int n = 0; n < steps; n++) {
        CHECK(set_real(&COUNTING, c, "voltage", start + n * step) == fmi2OK);
        CHECK(COUNTING.DoStep(c, start + n * step, step, fmi2True) == fmi2OK);
    }
    CHECK(counting_ticks == (long)ceil((start + steps * step) / TS - 1e-6) - first);
    for (long k = 0; k < counting_ticks; k++)
        CHECK_NEAR(counting_voltage[k], (double)(first + k) * TS, TS, 1e-6);
    COUNTING.FreeInstance(c);
}

/* A master that adds up its step, which is p/q sample times: after a million steps tick k still belongs to the
 * step that it lies in. The voltage is the number of the step. Halfway another instance goes on from the
 * serialized state, with times that are multiplied. */
static void accumulated_time(double sample_time, int p, int q, double start)
{
    const int steps = 1000000;
    const double step = p * sample_time / q;
    fmi2Component c = make_initializing(&COUNTING, start), other = make(&COUNTING);
    fmi2FMUstate state = NULL;
    struct state_bytes bytes;
    double time = start;
    long wrong = 0, ticks = 0;

    CHECK(set_real(&COUNTING, c, "sampleTime", sample_time) == fmi2OK);
    CHECK(COUNTING.ExitInitializationMode(c) == fmi2OK);
    counting_ticks = 0;
    for (int n = 0; n < steps; n++) {
        const fmi2ValueReference voltage = 0;
        const double number = n;
        if (n == steps / 2) {
            read_state(&COUNTING, c, &bytes);
            CHECK(COUNTING.DeSerializeFMUstate(other, bytes.byte, bytes.size, &state) == fmi2OK);
            CHECK(COUNTING.SetFMUstate(other, state) == fmi2OK);
        }
        fmi2Component instance = n < steps / 2 ? c : other;
        COUNTING.SetReal(instance, &voltage, 1, &number);
        wrong += COUNTING.DoStep(instance, n < steps / 2 ? time : start + n * step, step, fmi2True) != fmi2OK;
        time += step;
        for (; (long long)ticks * q < (n + 1LL) * p; ticks++)
            if (ticks < COUNTING_CAPACITY)
                wrong += counting_voltage[ticks] != number;
        wrong += counting_ticks != ticks;
    }
    if (!CHECK(wrong == 0))
        fprintf(stderr, "  %ld wrong: steps of %d/%d Ts = %g s from %g s; time is %g Ts off\n", wrong, p, q,
                sample_time, start, (time - start - steps * step) / sample_time);
    COUNTING.FreeFMUstate(other, &state);
    COUNTING.FreeInstance(c);
    COUNTING.FreeInstance(other);
}

static void empty_steps(const struct fmi2_api *m)
{
    fmi2Component c = make_running(m, 0.0);
    const double start = get_real(m, c, output_of(m));

    CHECK(set_real(m, c, input_of(m), signal(m, 0.01)) == fmi2OK);
    CHECK(m->DoStep(c, 0.0, 0.0, fmi2True) == fmi2OK); /* [0, 0) holds no tick, not even that at 0 */
    CHECK(get_real(m, c, output_of(m)) == start);
    CHECK(m->DoStep(c, 0.0, 0.3 * TS, fmi2True) <= fmi2Warning); /* the tick at 0 */
    const double first = get_real(m, c, output_of(m));
    CHECK(first != start);
    CHECK(m->DoStep(c, 0.3 * TS, 0.3 * TS, fmi2True) == fmi2OK); /* none */
    CHECK(m->DoStep(c, 0.6 * TS, 0.0, fmi2True) == fmi2OK);
    CHECK(get_real(m, c, output_of(m)) == first);
    CHECK(m->DoStep(c, 0.6 * TS, 0.4 * TS, fmi2True) == fmi2OK); /* [0.6, 1.0): none */
    CHECK(get_real(m, c, output_of(m)) == first);
    CHECK(m->DoStep(c, TS, TS, fmi2True) == fmi2OK); /* the tick at Ts */
    CHECK(get_real(m, c, output_of(m)) != first || m == &INVERSE);
    m->FreeInstance(c);
}

static void impossible_steps(const struct fmi2_api *m)
{
    fmi2Component c = make_running(m, 0.0);
    struct state_bytes before, after;

    CHECK(set_real(m, c, input_of(m), signal(m, 0.0)) == fmi2OK);
    CHECK(m->DoStep(c, 0.0, 5 * TS, fmi2True) == fmi2OK);
    read_state(m, c, &before);
    CHECK(m->DoStep(c, 5 * TS, -TS, fmi2True) == fmi2Error && log_says("negative"));
    CHECK(m->DoStep(c, 5 * TS, NAN, fmi2True) == fmi2Error && log_says("finite"));
    CHECK(m->DoStep(c, 5 * TS, INFINITY, fmi2True) == fmi2Error && log_says("finite"));
    CHECK(m->DoStep(c, NAN, TS, fmi2True) == fmi2Error && log_says("finite"));
    CHECK(m->DoStep(c, 4 * TS, TS, fmi2True) == fmi2Error && log_says("begins at") && log_says("0.0005") &&
          log_says("set an earlier FMU state"));
    CHECK(m->DoStep(c, 6 * TS, TS, fmi2True) == fmi2Error && log_says("begins at"));
    CHECK(m->DoStep(c, 5.01 * TS, TS, fmi2True) == fmi2Error);
    CHECK(m->DoStep(c, 5 * TS, 1e200, fmi2True) == fmi2Error && log_says("counted"));
    CHECK(m->DoStep(c, 5 * TS, 1e9, fmi2True) == fmi2Error && log_says("1e+13 ticks") &&
          log_says("at most 1e+09")); /* it would run for days, and nobody could interrupt it */
    read_state(m, c, &after);
    CHECK(same_state(&before, &after));
    CHECK(m->DoStep(c, 5 * TS, TS, fmi2True) == fmi2OK);
    m->FreeInstance(c);
}

static void stop_time(const struct fmi2_api *m)
{
    fmi2Component c = make(m);

    CHECK(m->SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2True, 10 * TS) == fmi2OK);
    CHECK(m->EnterInitializationMode(c) == fmi2OK && m->ExitInitializationMode(c) == fmi2OK);
    CHECK(set_real(m, c, input_of(m), signal(m, 0.0)) == fmi2OK);
    CHECK(m->DoStep(c, 0.0, 11 * TS, fmi2True) == fmi2Error && log_says("stopTime"));
    CHECK(m->DoStep(c, 0.0, 9 * TS, fmi2True) == fmi2OK);
    CHECK(m->DoStep(c, 9 * TS, 1.5 * TS, fmi2True) == fmi2Error && log_says("stopTime"));
    CHECK(m->DoStep(c, 9 * TS, TS, fmi2True) == fmi2OK); /* up to stopTime, despite rounding */
    CHECK(m->DoStep(c, 10 * TS, 0.0, fmi2True) == fmi2OK);
    m->FreeInstance(c);
}

/* A step that leaves the finite numbers is discarded: the state and its time are as before. */
static void discarded_step(void)
{
    fmi2Component c = make_running(&PLANT, 0.0);
    fmi2Status status = fmi2OK;
    fmi2Boolean terminated = fmi2False;
    double time = -1.0;

    CHECK(set_real(&PLANT, c, "voltage", 1e300) == fmi2OK);
    CHECK(set_slope(&PLANT, c, "voltage", 1e308) == fmi2OK);
    CHECK(PLANT.DoStep(c, 0.0, TS, fmi2True) == fmi2Warning); /* still finite, far out of range */
    const double held = get_real(&PLANT, c, "displacement");
    CHECK(set_real(&PLANT, c, "voltage", 1.7e308) == fmi2OK);
    forget_log();
    CHECK(PLANT.DoStep(c, TS, 1e5 * TS, fmi2True) == fmi2Discard);
    CHECK(logged.status == fmi2Discard && log_says("displacement") && log_says("finite"));
    CHECK(get_real(&PLANT, c, "displacement") == held);
    CHECK(PLANT.GetStatus(c, fmi2DoStepStatus, &status) == fmi2OK && status == fmi2Discard);
    CHECK(PLANT.GetRealStatus(c, fmi2LastSuccessfulTime, &time) == fmi2OK && time == TS);
    CHECK(PLANT.GetBooleanStatus(c, fmi2Terminated, &terminated) == fmi2OK && terminated);
    CHECK(PLANT.GetStatus(c, fmi2LastSuccessfulTime, &status) == fmi2Discard);
    int integer;
    CHECK(PLANT.GetIntegerStatus(c, fmi2DoStepStatus, &integer) == fmi2Discard);
    CHECK(set_real(&PLANT, c, "voltage", 50.0) == fmi2OK);
    CHECK(set_slope(&PLANT, c, "voltage", 0.0) == fmi2OK);
    CHECK(PLANT.DoStep(c, TS, TS, fmi2True) <= fmi2Warning);
    CHECK(PLANT.GetStatus(c, fmi2DoStepStatus, &status) == fmi2OK && status != fmi2Discard);
    CHECK(PLANT.GetBooleanStatus(c, fmi2Terminated, &terminated) == fmi2OK && !terminated);
    PLANT.FreeInstance(c);
}

/* For voltages beyond those that the displacements in range ask for: at rest -3.2 to 110.4 V. */
static fmi2Component make_for_any_voltage(const struct fmi2_api *m)
{
    fmi2Component c = make_initializing(m, 0.0);

    CHECK(set_real(m, c, "voltageMin", -2000.0) == fmi2OK && set_real(m, c, "voltageMax", 2000.0) == fmi2OK);
    CHECK(m->ExitInitializationMode(c) == fmi2OK);
    return c;
}

/* A range is left: said once, as a warning that the step itself returns. */
static void warnings(void)
{
    fmi2Component c = make_for_any_voltage(&INVERSE);
    const fmi2String all = "logAll";

    CHECK(INVERSE.SetDebugLogging(c, fmi2True, 1, &all) == fmi2OK);
    CHECK(set_real(&INVERSE, c, "reference", 1e-3) == fmi2OK);
    forget_log();
    CHECK(INVERSE.DoStep(c, 0.0, TS, fmi2True) == fmi2Warning);
    CHECK(logged.count == 1 && logged.status == fmi2Warning);
    CHECK(log_says(
        "the reference, 1000 \xc2\xb5m at 0 s, is outside displacementMin..displacementMax, 0 to 16 \xc2\xb5m"));
    CHECK(get_boolean(&INVERSE, c, "saturated") == 1);
    forget_log();
    CHECK(INVERSE.DoStep(c, TS, TS, fmi2True) == fmi2OK && logged.count == 0);
    CHECK(set_real(&INVERSE, c, "reference", 8e-6) == fmi2OK);
    CHECK(INVERSE.DoStep(c, 2 * TS, 50 * TS, fmi2True) == fmi2OK);
    CHECK(get_boolean(&INVERSE, c, "saturated") == 0);
    INVERSE.FreeInstance(c);
}

/* At which tick of a step, with which value and beyond which range, in numbers; and a flag for the host that
 * does not read logs. */
static void out_of_range(void)
{
    fmi2Component c = make_running(&PLANT, 0.0);

    CHECK(set_real(&PLANT, c, "voltage", 100.0) == fmi2OK);
    CHECK(set_slope(&PLANT, c, "voltage", 1000.0) == fmi2OK);
    CHECK(get_boolean(&PLANT, c, "outOfRange") == 0);
    forget_log();
    CHECK(PLANT.DoStep(c, 0.0, 10 * TS, fmi2True) == fmi2OK && logged.count == 0);
    CHECK(get_boolean(&PLANT, c, "outOfRange") == 0);
    CHECK(set_real(&PLANT, c, "voltage", 109.95) == fmi2OK);
    CHECK(PLANT.DoStep(c, 10 * TS, 3 * TS, fmi2True) == fmi2Warning && logged.count == 1);
    CHECK(log_says("the voltage left voltageMin..voltageMax, 0 to 110 V") &&
          log_says("it is 110.05 V at 0.0011 s"));
    CHECK(log_says("logged once") && strcmp(logged.category, "logStatusWarning") == 0);
    CHECK(get_boolean(&PLANT, c, "outOfRange") == 1);
    CHECK(set_real(&PLANT, c, "voltage", 115.0) == fmi2OK && set_slope(&PLANT, c, "voltage", 0.0) == fmi2OK);
    forget_log();
    CHECK(PLANT.DoStep(c, 13 * TS, TS, fmi2True) == fmi2OK && logged.count == 0); /* said already */
    CHECK(PLANT.DoStep(c, 14 * TS, 0.1, fmi2True) == fmi2Warning && logged.count == 1);
    CHECK(log_says("displacementMin..displacementMax, 0 to 16 \xc2\xb5m") && log_says("it is 16.0"));
    CHECK(set_real(&PLANT, c, "voltage", 105.0) == fmi2OK);
    CHECK(PLANT.DoStep(c, 14 * TS + 0.1, TS, fmi2True) == fmi2OK); /* the voltage is back, the core not yet */
    CHECK(get_boolean(&PLANT, c, "outOfRange") == 1);
    CHECK(PLANT.DoStep(c, 15 * TS + 0.1, 0.1, fmi2True) == fmi2OK);
    CHECK(get_boolean(&PLANT, c, "outOfRange") == 0 && logged.count == 1);
    PLANT.FreeInstance(c);
}

/* From end to end of the range and back, 5 Hz, inverse before plant. Returns how many ticks were saturated; at
 * the others the plant is at the reference, and within its range. */
static int there_and_back(fmi2Component inverse, fmi2Component plant)
{
    int saturated = 0;

    for (int k = 0; k < 2000; k++) {
        const double reference = fmin(8e-6 * (1.0 - cos(0.0031415926535897932 * k)), 16e-6);
        CHECK(set_real(&INVERSE, inverse, "reference", reference) == fmi2OK);
        CHECK(INVERSE.DoStep(inverse, k * TS, TS, fmi2True) <= fmi2Warning);
        CHECK(set_real(&PLANT, plant, "voltage", get_real(&INVERSE, inverse, "voltage")) == fmi2OK);
        CHECK(PLANT.DoStep(plant, k * TS, TS, fmi2True) <= fmi2Warning);
        if (get_boolean(&INVERSE, inverse, "saturated"))
            saturated++;
        else
            CHECK_NEAR(get_real(&PLANT, plant, "displacement"), reference, 16e-6, 1e-9);
        CHECK(get_boolean(&PLANT, plant, "outOfRange") == 0);
    }
    PLANT.FreeInstance(plant);
    INVERSE.FreeInstance(inverse);
    return saturated;
}

/* The inverse may aim at the ends of the range themselves, and gives the ends of the voltage range: rounding is
 * not beyond them. */
static void the_ends_are_within(void)
{
    const int cut = there_and_back(make_running(&INVERSE, 0.0), make_running(&PLANT, 0.0));

    CHECK(there_and_back(make_for_any_voltage(&INVERSE), make_for_any_voltage(&PLANT)) == 0);
    CHECK(cut > 0 && cut < 400); /* 0 um asks for less than 0 V, 16 um for more than 110 V */
}

/* A step of the reference within its range may ask for more than the voltages that the set holds for. */
static void voltage_limit(void)
{
    fmi2Component c = make_running(&INVERSE, 0.0);
    const fmi2String all = "logAll";
    int saturated = 0;

    CHECK(INVERSE.SetDebugLogging(c, fmi2True, 1, &all) == fmi2OK);
    CHECK(set_real(&INVERSE, c, "reference", 15e-6) == fmi2OK);
    forget_log();
    CHECK(INVERSE.DoStep(c, 0.0, TS, fmi2True) == fmi2Warning && logged.count == 1);
    CHECK(log_says("a voltage outside voltageMin..voltageMax, 0 to 110 V"));
    for (int k = 1; k < 100; k++) {
        forget_log();
        CHECK(get_real(&INVERSE, c, "voltage") >= 0.0 && get_real(&INVERSE, c, "voltage") <= 110.0);
        saturated += get_boolean(&INVERSE, c, "saturated");
        CHECK(INVERSE.DoStep(c, k * TS, TS, fmi2True) == fmi2OK && logged.count == 0);
    }
    CHECK(saturated > 1 && saturated < 50);
    INVERSE.FreeInstance(c);
}

static void of_model(const struct fmi2_api *m)
{
    any_step_same_ticks(m);
    held_input_same_ticks(m);
    empty_steps(m);
    impossible_steps(m);
    stop_time(m);
}

int main(void)
{
    const double starts[] = { 0.0, 1.0, 0.123456, -0.05, 1e4, 12345.6789 };

    of_model(&PLANT);
    of_model(&INVERSE);
    for (int i = 0; i < 6; i++) {
        ticks_see_their_own_time(starts[i], TS, 300);
        ticks_see_their_own_time(starts[i], TS / 3.0, 900);
        ticks_see_their_own_time(starts[i], 7.3 * TS, 50);
        ticks_see_their_own_time(starts[i], 100.0 * TS, 4);
    }
    accumulated_time(TS, 1, 1, 0.0);
    accumulated_time(TS, 1, 3, 0.0);
    accumulated_time(TS, 1, 1, 1.0);
    accumulated_time(TS, 1, 1, 1e6); /* here and below, time ends more than a hundredth of Ts off */
    accumulated_time(1e-5, 1, 1, 1e6);
    accumulated_time(1e-5, 1, 10, 1e6);
    accumulated_time(1e-5, 10, 1, 1e6);
    accumulated_time(1e-5, 5, 2, 1e6);
    discarded_step();
    warnings();
    out_of_range();
    the_ends_are_within();
    voltage_limit();
    return check_report("fmi2 time");
}
