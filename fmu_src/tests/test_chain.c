/* The chain without effects forwards and backwards is the identity; out of reach it does not wind up;
 * tangents. */
#include "check.h"
#include "effect_sets.h"

CHECK_MAIN;

enum { SETS = 300, TICKS = 200 };

static const struct chain_surroundings REST = { 0.0, 293.15, 0.0 };
static const struct chain_surroundings STILL = { 0.0, 0.0, 0.0 };

/* For any voltage: random references ask for thousands of volts. */
static int random_set(uint64_t *seed, struct chain_parameters *p)
{
    *p = (struct chain_parameters){
        .sampleTime = 1e-4, .voltageMin = -1e9, .voltageMax = 1e9, .displacementMax = 16.0
    };
    p->ruleCount = random_usable_rules(seed, p->rule);
    p->initialDisplacement = random_between(seed, 0.0, 16.0);
    return p->ruleCount;
}

static void table_1(struct chain_parameters *p)
{
    *p = (struct chain_parameters){ .sampleTime = 1e-4,
                                    .voltageMax = 150.0,
                                    .displacementMax = 16.0,
                                    .ruleCount = 3,
                                    .initialDisplacement = 1.0 };
    memcpy(p->rule, TABLE_1, sizeof TABLE_1);
}

/* plant(inverse(reference)) = reference, tick for tick. */
static void inverse_then_step(const struct chain *chain, const struct chain_parameters *p, uint64_t *seed)
{
    struct chain_state plant, inverse;
    unsigned saturated;

    chain_reset(chain, &plant, p);
    chain_reset(chain, &inverse, p);
    CHECK(plant.core.y == p->initialDisplacement);
    for (int k = 0; k < TICKS; k++) {
        const double reference = random_between(seed, 0.5, 15.5);
        const double voltage = chain_inverse(chain, &inverse, reference, &REST, &saturated);
        CHECK(!saturated);
        CHECK_CLOSE(chain_step(chain, &plant, voltage, &REST), reference, 1e-9);
        CHECK_CLOSE(plant.core.y, inverse.core.y, 1e-9);
        plant = inverse; /* random references make voltages of thousands of volts: no drift here */
    }
}

/* inverse(plant(voltage)) = voltage, as long as the plant stays within reach. */
static void step_then_inverse(const struct chain *chain, const struct chain_parameters *p, uint64_t *seed)
{
    struct chain_state plant, inverse;
    unsigned saturated;
    long within = 0;

    chain_reset(chain, &plant, p);
    chain_reset(chain, &inverse, p);
    for (int k = 0; k < TICKS; k++) {
        const double hold = chain_equilibrium(chain, &plant);
        const double voltage = hold + random_between(seed, 0.1, 3.0) * (plant.core.y < 8.0 ? 1.0 : -1.0);
        const double displacement = chain_step(chain, &plant, voltage, &REST);
        const double back = chain_inverse(chain, &inverse, displacement, &REST, &saturated);
        CHECK(!saturated);
        within += !saturated;
        CHECK_NEAR(back, voltage, fmax(1.0, fabs(voltage)), 1e-9);
        CHECK(inverse.core.y == plant.core.y);
    }
    CHECK(within == TICKS);
}

static void identity(void)
{
    struct chain_parameters p;
    struct chain chain;
    uint64_t seed = 3;
    int largest = 0, smallest = IT2_MAX_RULES;

    for (int i = 0; i < SETS; i++) {
        const int count = random_set(&seed, &p);
        largest = count > largest ? count : largest;
        smallest = count < smallest ? count : smallest;
        chain_prepare(&chain, &p);
        inverse_then_step(&chain, &p, &seed);
        step_then_inverse(&chain, &p, &seed);
    }
    CHECK(smallest == 1 && largest == IT2_MAX_RULES);
}

static void no_wind_up(void)
{
    const double beyond[] = { 16.5, 40.0, 1e6, INFINITY, -0.5, -40.0, -INFINITY };
    struct chain_parameters p;
    struct chain chain;
    unsigned saturated;

    table_1(&p);
    p.voltageMin = -1e4, p.voltageMax = 1e4;
    chain_prepare(&chain, &p);
    for (size_t i = 0; i < sizeof beyond / sizeof beyond[0]; i++) {
        const double end = beyond[i] > 0.0 ? 16.0 : 0.0;
        struct chain_state pushed = { .core = { 8.0 } }, at_end = pushed;
        for (int k = 0; k < 100; k++) {
            const double voltage = chain_inverse(&chain, &pushed, beyond[i], &REST, &saturated);
            CHECK(saturated && isfinite(voltage));
            CHECK(voltage == chain_inverse(&chain, &at_end, end, &REST, &saturated));
            CHECK(!saturated); /* the end itself is within reach */
        }
        CHECK(pushed.core.y == end);
        CHECK(chain_inverse(&chain, &pushed, 7.0, &REST, &saturated) ==
              chain_inverse(&chain, &at_end, 7.0, &REST, &saturated));
        CHECK(!saturated);
    }
}

/* The voltage stays within its limits whatever is asked for, and wherever the inverse does not say so, the
 * plant is at the reference. */
static void within_the_voltages(uint64_t *seed)
{
    struct chain_parameters p;
    struct chain chain;
    struct chain_state plant, inverse;
    unsigned limits;
    double reference = 8.0;
    long met = 0, cut = 0;

    table_1(&p);
    p.voltageMin = random_between(seed, 0.0, 20.0);
    p.voltageMax = random_between(seed, 60.0, 100.0);
    p.initialDisplacement = random_between(seed, -1.0, 17.0); /* it may rest beyond them */
    chain_prepare(&chain, &p);
    chain_reset(&chain, &plant, &p);
    chain_reset(&chain, &inverse, &p);
    const double start = chain_equilibrium(&chain, &inverse);
    CHECK(start >= p.voltageMin && start <= p.voltageMax);
    for (int k = 0; k < 20 * TICKS; k++) {
        if (k % 50 == 0)
            reference = random_between(seed, 5.0, 9.0);
        const double noise = k / TICKS % 2 ? random_between(seed, -0.5, 0.5) : 0.0;
        const double out = k / TICKS % 5 == 4 ? 20.0 : 0.0;
        const double aim = reference + noise + out;
        const double voltage = chain_inverse(&chain, &inverse, aim, &REST, &limits);
        const double reached = chain_step(&chain, &plant, voltage, &REST);
        CHECK(voltage >= p.voltageMin && voltage <= p.voltageMax);
        CHECK(!(limits & CHAIN_VOLTAGE_RANGE) || voltage == p.voltageMin || voltage == p.voltageMax);
        CHECK(!out || limits & CHAIN_REFERENCE_RANGE);
        CHECK_CLOSE(inverse.core.y, plant.core.y, 1e-13); /* it does not wind up */
        if (!limits)
            CHECK_CLOSE(reached, aim, 1e-12);
        if (k / TICKS % 5 != 4 && !noise && k % 50 == 49)
            CHECK(!limits); /* and comes back at once: a step takes some 20 ticks at full voltage */
        met += !limits;
        cut += (limits & CHAIN_VOLTAGE_RANGE) != 0;
    }
    CHECK(met > 5 * TICKS && cut > TICKS);
}

/* What `map` makes of one tick from (y, input). */
typedef struct chain_point map(const struct chain *, double y, double input);

static struct chain_point step_map(const struct chain *chain, double y, double input)
{
    struct chain_point point = { .state = { .core = { y } } };
    point.output = chain_step(chain, &point.state, input, &REST);
    return point;
}

static struct chain_point inverse_map(const struct chain *chain, double y, double input)
{
    struct chain_point point = { .state = { .core = { y } } };
    unsigned saturated;
    point.output = chain_inverse(chain, &point.state, input, &REST, &saturated);
    return point;
}

static void tangent(const struct chain *chain, map *f, struct chain_point d, double y, double input, double d_y,
                    double d_input)
{
    const double h = 1e-5;
    const struct chain_point after = f(chain, y + h * d_y, input + h * d_input);
    const struct chain_point before = f(chain, y - h * d_y, input - h * d_input);
    const double slope = (after.output - before.output) / (2.0 * h);

    CHECK_NEAR(d.output, slope, fmax(1.0, fabs(slope)), 1e-6);
    CHECK_NEAR(d.state.core.y, (after.state.core.y - before.state.core.y) / (2.0 * h), 1.0, 1e-6);
}

static void tangents(void)
{
    struct chain_parameters p;
    struct chain chain;
    uint64_t seed = 17;

    for (int i = 0; i < 200; i++) {
        random_set(&seed, &p);
        if (i % 2)
            p.voltageMin = 0.0, p.voltageMax = 100.0; /* most of what is asked for is beyond */
        chain_prepare(&chain, &p);
        /* within the range and beyond its ends */
        const double y = i % 3 == 0 ? random_between(&seed, 1.0, 15.0)
                                    : random_between(&seed, 0.5, 60.0) * (i % 3 == 1 ? -1.0 : 1.0) +
                                          (i % 3 == 1 ? 0.0 : 16.0);
        const double aim = random_between(&seed, 1.0, 15.0);
        const double d_y = random_between(&seed, -1.0, 1.0), d_input = random_between(&seed, -1.0, 1.0);
        const struct chain_state state = { .core = { y } }, d_state = { .core = { d_y } };
        tangent(&chain, step_map, chain_step_tangent(&chain, &state, 50.0, &REST, d_state, d_input, &STILL), y,
                50.0, d_y, d_input);
        tangent(&chain, inverse_map,
                chain_inverse_tangent(&chain, &state, aim, &REST, d_state, d_input, &STILL), y, aim, d_y,
                d_input);
        /* out of reach the reference no longer matters */
        tangent(&chain, inverse_map,
                chain_inverse_tangent(&chain, &state, 17.0, &REST, d_state, d_input, &STILL), y, 17.0, d_y,
                d_input);
    }
}

/* The parameters that the equilibrium depends on: initialDisplacement, the ends of the range and the limits of the
 * voltage where it is beyond them, and those of the rules. */
static double *parameter(struct chain_parameters *p, int i)
{
    double *const first[] = { &p->initialDisplacement, &p->displacementMin, &p->displacementMax, &p->voltageMin,
                              &p->voltageMax };

    return i < 5 ? first[i] : (double *)(void *)p->rule + (i - 5);
}

static void equilibrium_tangent(double start, double voltage_min, double voltage_max)
{
    struct chain_parameters p;
    struct chain chain;
    struct chain_state state;

    table_1(&p);
    p.initialDisplacement = start;
    p.voltageMin = voltage_min, p.voltageMax = voltage_max;
    chain_prepare(&chain, &p);
    chain_reset(&chain, &state, &p);
    const double hold = chain_hold(&chain, &state);
    CHECK(hold_voltage(&p) == fmin(fmax(hold, voltage_min), voltage_max));
    CHECK_CLOSE(chain_step(&chain, &state, hold, &REST), p.initialDisplacement, 1e-13);
    chain_reset(&chain, &state, &p);
    for (int i = 0; i < 5 + 3 * IT2_RULE_PARAMETERS; i++) {
        struct chain_parameters d = { .sampleTime = 0.0 }, up = p, down = p;
        const double h = 1e-5 * fmax(0.1, fabs(*parameter(&p, i)));
        *parameter(&d, i) = 1.0;
        *parameter(&up, i) += h;
        *parameter(&down, i) -= h;
        const double slope = (hold_voltage(&up) - hold_voltage(&down)) / (2.0 * h);
        CHECK_NEAR(chain_equilibrium_tangent(&chain, &state, &p, &d), slope, fmax(1.0, fabs(slope)), 1e-6);
    }
}

int main(void)
{
    uint64_t seed = 5;

    identity();
    no_wind_up();
    for (int i = 0; i < SETS; i++)
        within_the_voltages(&seed);
    tangents();
    equilibrium_tangent(1.0, 0.0, 150.0);
    equilibrium_tangent(1.0, 10.0, 150.0);
    equilibrium_tangent(1.0, -50.0, 1.0);
    equilibrium_tangent(-30.0, -1e4, 1e4);
    equilibrium_tangent(70.0, -1e4, 1e4);
    equilibrium_tangent(-30.0, 0.0, 110.0);
    equilibrium_tangent(70.0, 0.0, 110.0);
    return check_report("chain");
}
