/* Ticks are counted exactly, however a master cuts time and adds it up: the clock alone, without a model.
 *
 *   test_clock [STEPS]     the longest runs have 1e8 steps, or as many as are asked for */
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "fmu_clock.h"

CHECK_MAIN;

/* Ways to compute the n-th communication point and the length of the step from there. */
enum master {
    ADDS,               /* t += h */
    MULTIPLIES,         /* t = t0 + n h */
    SUBTRACTS,          /* the same, and the length is the difference of two such times */
    ADDS_AND_SUBTRACTS, /* t += h, and the length is the difference */
    MASTERS
};

struct run {
    double sample_time;
    int numerator, denominator; /* of the step in sample times */
    double start;               /* a tick */
    double steps;
};

static struct fmu_clock clock_at(double start, double sample_time)
{
    struct fmu_clock clock = { 0 };
    char text[128];

    CHECK(fmu_clock_setup(&clock, start, false, 0.0, text, sizeof text));
    fmu_clock_start(&clock, sample_time);
    return clock;
}

/* Steps once; counts what is refused. */
static long step_once(struct fmu_clock *clock, double sample_time, double time, double step)
{
    struct fmu_clock end;
    const bool refused = !fmu_clock_step(clock, sample_time, time, step, &end);

    *clock = end;
    return refused;
}

/* The short cut does what the rules do. */
static void short_cut(void)
{
    const double ts = 1e-4;
    struct fmu_clock clock = clock_at(0.0, ts), end, by_rules;
    double time = 0.0;
    long wrong = 0;

    for (int n = 0; n < 1000000; n++) {
        const double step = n % 100 == 17 ? 0.7 * ts : n % 100 == 29 ? 0.3 * ts : n % 100 == 50 ? 5 * ts : ts;
        wrong += !fmu_clock_step(&clock, ts, time, step, &end);
        wrong += !fmu_clock_any_step(&clock, ts, time, step, &by_rules);
        wrong += memcmp(&end, &by_rules, sizeof end) != 0;
        clock = end;
        time += step;
    }
    CHECK(wrong == 0);
}

/* After n steps of p/q sample times the ticks up to before n p/q have run, for every n. */
static void counts(enum master master, const struct run *r)
{
    const double step = r->numerator * r->sample_time / r->denominator;
    struct fmu_clock clock = clock_at(r->start, r->sample_time);
    const int64_t first = clock.next_tick, steps = (int64_t)r->steps;
    int64_t due = first, part = 0; /* due = first + ceil(n p / q) */
    double added = r->start;
    long wrong = 0;

    CHECK(clock.rest == 0.0 && fabs((double)first * r->sample_time - r->start) <= 1e-15 * fabs(r->start));
    for (int64_t n = 0; n < steps; n++) {
        const bool adds = master == ADDS || master == ADDS_AND_SUBTRACTS;
        const double time = adds ? added : r->start + (double)n * step;
        const double next = adds ? added + step : r->start + (double)(n + 1) * step;
        const bool subtracts = master == SUBTRACTS || master == ADDS_AND_SUBTRACTS;
        wrong += step_once(&clock, r->sample_time, time, subtracts ? next - time : step);
        added = next;
        for (part += r->numerator; part > 0; part -= r->denominator)
            due++;
        wrong += clock.next_tick != due;
    }
    if (!CHECK(wrong == 0))
        fprintf(stderr, "  master %d, Ts %g, step %d/%d Ts, from %g s: %ld steps of %g are wrong\n", master,
                r->sample_time, r->numerator, r->denominator, r->start, wrong, r->steps);
    if (master == ADDS && r->steps >= (r->start == 1e6 ? 1e6 : 1e8)) /* by the master's time a tick slips */
        CHECK(fabs(added - r->start - r->steps * step) > 2e-3 * r->sample_time);
}

static void any_master(double steps)
{
    const struct run runs[] = {
        { 1e-5, 1, 1, 0.0, steps },         { 1e-5, 1, 10, 0.0, steps / 25 },
        { 1e-5, 10, 1, 0.0, steps / 25 },   { 1e-5, 5, 2, 0.0, steps / 25 },
        { 1e-4, 1, 1, 0.0, steps / 25 },    { 1e-4, 1, 3, 0.0, steps / 50 },
        { 1e-5, 1, 1, 1e6, steps / 50 },    { 1e-5, 1, 10, 1e6, steps / 50 },
        { 1e-5, 10, 1, 1e6, steps / 50 },   { 1e-5, 5, 2, 1e6, steps / 50 },
        { 1e-4, 1, 1, 1e6, steps / 50 },    { 1.0 / 3e4, 1, 1, 0.0, steps / 50 },
        { 1e-4, 1, 1, -500.0, steps / 50 }, { 1e-4, 100, 1, 0.0, steps / 100 },
    };

    for (size_t i = 0; i < sizeof runs / sizeof runs[0]; i++) {
        counts(ADDS, &runs[i]);
        for (int master = MULTIPLIES; master < MASTERS; master++) {
            struct run shorter = runs[i];
            shorter.steps = steps / 100;
            counts((enum master)master, &shorter);
        }
    }
}

static uint64_t random_bits(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return *seed >> 33;
}

/* Steps of any length, in units of a 512th of a sample time, that a master adds up. */
static void variable_steps(double sample_time, double start, long steps)
{
    enum { UNITS = 512 };
    struct fmu_clock clock = clock_at(start, sample_time);
    const int64_t first = clock.next_tick;
    int64_t units = 0;
    uint64_t seed = 1;
    double time = start;
    long wrong = 0;

    for (long n = 0; n < steps; n++) {
        const uint64_t longest = n % 5 == 0 ? 20 * UNITS : 2 * UNITS;
        const int64_t length = (int64_t)(random_bits(&seed) % longest);
        const double step = (double)length / UNITS * sample_time;
        wrong += step_once(&clock, sample_time, time, step);
        time += step;
        units += length;
        wrong += clock.next_tick != first + (units + UNITS - 1) / UNITS;
    }
    if (!CHECK(wrong == 0))
        fprintf(stderr, "  Ts %g from %g s: %ld of %ld variable steps are wrong\n", sample_time, start, wrong,
                steps);
    if (start == 1e6 && steps >= 1000000)
        CHECK(fabs(time - start - (double)units / UNITS * sample_time) > 2e-3 * sample_time);
}

/* One instance, stepped in turns by masters of every kind that each have their own time: as where states
 * are saved by one and restored by another. */
static void many_masters(double sample_time, double start, long steps)
{
    struct fmu_clock clock = clock_at(start, sample_time);
    const int64_t first = clock.next_tick;
    uint64_t seed = 7;
    double by_step = start, by_tenth = start;
    long wrong = 0;

    for (long n = 0; n < steps; n++) {
        const double exact = start + (double)n * sample_time;
        const double times[] = { by_step, by_tenth, exact };
        wrong += step_once(&clock, sample_time, times[random_bits(&seed) % 3], sample_time);
        wrong += clock.next_tick != first + n + 1;
        by_step += sample_time;
        for (int i = 0; i < 10; i++)
            by_tenth += sample_time / 10;
    }
    CHECK(wrong == 0);
    CHECK(start == 0.0 || fabs(by_step - by_tenth) > 2e-3 * sample_time);
}

/* Two rates: an instance that is stepped a hundred times less often than the master adds up. */
static void slow_and_fast(double sample_time, double start, long steps)
{
    struct fmu_clock fast = clock_at(start, sample_time), slow = fast;
    double time = start;
    long wrong = 0;

    for (long n = 0; n < steps; n++) {
        if (n % 100 == 0) {
            wrong += fast.next_tick != slow.next_tick;
            wrong += step_once(&slow, sample_time, time, 100 * sample_time / 4);
        }
        wrong += step_once(&fast, sample_time, time, sample_time / 4);
        time += sample_time / 4;
    }
    CHECK(wrong == 0);
}

/* A master that counts in nanoseconds, of which a sample time is no whole number. */
static void nanoseconds(void)
{
    const double sample_time = 1.0 / 3e4;
    struct fmu_clock clock = clock_at(0.0, sample_time);
    long wrong = 0;

    for (int64_t n = 0; n < 1000000; n++) {
        const int64_t from = n * 100000 / 3, to = (n + 1) * 100000 / 3;
        wrong += step_once(&clock, sample_time, (double)from * 1e-9, (double)(to - from) * 1e-9);
        wrong += clock.next_tick != n + 1;
    }
    CHECK(wrong == 0);
}

/* Lengths in single precision, times in double: they contradict each other more and more. */
static void careless_lengths(void)
{
    const double sample_time = 1e-4, step = (double)1e-4f;
    struct fmu_clock clock = clock_at(0.0, sample_time);
    long wrong = 0;

    CHECK(step != sample_time);
    for (int64_t n = 0; n < 1000000; n++) {
        wrong += step_once(&clock, sample_time, (double)n * sample_time, step);
        wrong += clock.next_tick != n + 1;
    }
    CHECK(wrong == 0);
}

/* Until a stop time, with a last step that is as long as what is left. */
static void last_step_is_shortened(void)
{
    const double sample_time = 1e-4, stop = 100.0;
    struct fmu_clock clock = { 0 };
    char text[256];
    double time = 0.0;
    long wrong = 0;

    CHECK(fmu_clock_setup(&clock, 0.0, true, stop, text, sizeof text));
    fmu_clock_start(&clock, sample_time);
    while (time < stop) {
        const double step = stop - time < sample_time ? stop - time : sample_time;
        wrong += step_once(&clock, sample_time, time, step);
        time += step;
    }
    CHECK(wrong == 0 && clock.next_tick == 1000000);
    struct fmu_clock end;
    CHECK(!fmu_clock_step(&clock, sample_time, time, sample_time, &end));
    CHECK(strstr(fmu_clock_refusal(&clock, sample_time, time, sample_time, text, sizeof text), "stopTime"));
}

/* Where the clock is set to the master's time, no tick runs twice and none is left out. */
static void set_back(void)
{
    const double ts = 1e-4;
    struct fmu_clock clock = clock_at(0.0, ts), before;

    CHECK(step_once(&clock, ts, 0.0, 1000.0009 * ts) == 0 && clock.next_tick == 1000);
    clock.time = 1000.0 * ts - 0.9 * ts; /* as if the lengths had run away from the times */
    before = clock;
    CHECK(step_once(&clock, ts, clock.time, 0.5 * ts) == 0);
    CHECK(clock.next_tick == before.next_tick && clock.additions == 1);
    CHECK(fabs(fmu_clock_ticks(&clock) - 999.6) < 1e-9);
    CHECK(step_once(&clock, ts, clock.time, 1.5 * ts) == 0 && clock.next_tick == 1002);
}

static bool refused(const struct fmu_clock *clock, double time, double step, const char *reason)
{
    struct fmu_clock end;
    char text[256] = "";

    if (fmu_clock_step(clock, 1e-4, time, step, &end))
        return false;
    fmu_clock_refusal(clock, 1e-4, time, step, text, sizeof text);
    if (!strstr(text, reason))
        fprintf(stderr, "'%s' is not in: %s\n", reason, text);
    return strstr(text, reason) != NULL;
}

static void refusals(void)
{
    struct fmu_clock clock = clock_at(0.0, 1e-4), end;

    CHECK(step_once(&clock, 1e-4, 0.0, 5e-4) == 0);
    CHECK(refused(&clock, 5e-4, -1e-4, "negative") && refused(&clock, 5e-4, NAN, "finite") &&
          refused(&clock, NAN, 1e-4, "finite") && refused(&clock, 5e-4, INFINITY, "finite"));
    CHECK(refused(&clock, 4e-4, 1e-4, "begins at") && refused(&clock, 6e-4, 1e-4, "begins at") &&
          refused(&clock, 5.01e-4, 1e-4, "begins at"));
    CHECK(refused(&clock, 5e-4, 1e200, "counted"));
    CHECK(refused(&clock, 5e-4, 1e9, "1e+13 ticks") && refused(&clock, 5e-4, 1e9, "at most 1e+09"));
    CHECK(fmu_clock_step(&clock, 1e-4, 5e-4, 1e5, &end) && end.next_tick == 1000000005);
    clock = clock_at(1e300, 1e-4);
    CHECK(refused(&clock, 1e300, 1e-4, "counted"));
}

static void setup(void)
{
    struct fmu_clock clock = { 0 };
    char text[128];

    CHECK(fmu_clock_setup(&clock, 1.0, true, INFINITY, text, sizeof text) && clock.stop_time == INFINITY);
    CHECK(fmu_clock_setup(&clock, 1.0, false, NAN, text, sizeof text) && clock.stop_time == INFINITY);
    CHECK(fmu_clock_setup(&clock, 1.0, true, 1.0, text, sizeof text) && clock.stop_time == 1.0);
    CHECK(!fmu_clock_setup(&clock, NAN, false, 0.0, text, sizeof text) && strstr(text, "startTime"));
    CHECK(!fmu_clock_setup(&clock, 1.0, true, NAN, text, sizeof text) && strstr(text, "stopTime"));
    CHECK(!fmu_clock_setup(&clock, 1.0, true, -INFINITY, text, sizeof text));
    CHECK(!fmu_clock_setup(&clock, 1.0, true, 0.5, text, sizeof text));
    CHECK(clock.time == 1.0 && clock.stop_time == 1.0);
}

/* Every clock of a run is one, and none that is made up. */
static void plausible(void)
{
    const double ts = 1e-4;
    struct fmu_clock clock = clock_at(-1.0, ts);
    long wrong = 0;

    for (int n = 0; n < 100000; n++) {
        wrong += step_once(&clock, ts, clock.time, n % 7 * 0.3 * ts);
        wrong += !fmu_clock_plausible(&clock, ts);
    }
    CHECK(wrong == 0);
    struct fmu_clock c;
    const struct fmu_clock good = clock;
#define MADE_UP(change) (c = good, (void)(change), CHECK(!fmu_clock_plausible(&c, ts)))
    MADE_UP(c.tick = INT64_MAX);
    MADE_UP(c.tick = INT64_MIN);
    MADE_UP(c.tick += 10);
    MADE_UP(c.next_tick = INT64_MAX);
    MADE_UP(c.next_tick = INT64_MIN);
    MADE_UP(c.next_tick -= 1);
    MADE_UP(c.additions = -1);
    MADE_UP(c.additions = INT64_MAX);
    MADE_UP(c.rest = NAN);
    MADE_UP(c.rest = -1e-3);
    MADE_UP(c.rest = 1.0);
    MADE_UP(c.time = NAN);
    MADE_UP(c.time = INFINITY);
    MADE_UP(c.time += ts);
    MADE_UP(c.stop_time = NAN);
    MADE_UP(c.stop_time = -INFINITY);
}

int main(int count, char **argument)
{
    const double steps = count > 1 ? strtod(argument[1], NULL) : 1e8;

    setup();
    refusals();
    plausible();
    short_cut();
    set_back();
    nanoseconds();
    careless_lengths();
    last_step_is_shortened();
    variable_steps(1e-5, 0.0, (long)(steps / 20));
    variable_steps(1e-4, 1e6, (long)(steps / 20));
    many_masters(1e-5, 0.0, (long)(steps / 100));
    many_masters(1e-4, 1e6, (long)(steps / 100));
    slow_and_fast(1e-5, 0.0, (long)(steps / 50));
    slow_and_fast(1e-4, 1e6, (long)(steps / 100));
    any_master(steps);
    return check_report("clock");
}
