/* The chain forwards and backwards is the identity; out of reach it does not wind up; tangents. */
#include "chain.h"
#include "check.h"
#include "sets.h"

CHECK_MAIN;

enum { SETS = 300, TICKS = 200 };

static const struct chain_surroundings REST = { 0.0, 293.15, 0.0 };
static const struct chain_surroundings STILL = { 0.0, 0.0, 0.0 };

static int random_set(uint64_t *seed, struct chain_parameters *p)
{
    *p = (struct chain_parameters){ .sampleTime = 1e-4, .voltageMax = 150.0, .displacementMax = 16.0 };
    p->ruleCount = random_usable_rules(seed, p->rule);
    p->initialDisplacement = random_between(seed, 0.0, 16.0);
    return p->ruleCount;
}

static void table_1(struct chain_parameters *p)
{
    *p = (struct chain_parameters){ .sampleTime = 1e-4, .voltageMax = 150.0, .displacementMax = 16.0,
                                    .ruleCount = 3, .initialDisplacement = 1.0 };
    memcpy(p->rule, TABLE_1, sizeof TABLE_1);
}

/* plant(inverse(reference)) = reference, tick for tick. */
static void inverse_then_step(const struct chain *chain, const struct chain_parameters *p,
                              uint64_t *seed)
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
static void step_then_inverse(const struct chain *chain, const struct chain_parameters *p,
                              uint64_t *seed)
{
    struct chain_state plant, inverse;
    unsigned saturated;
    long within = 0;

    chain_reset(chain, &plant, p);
    chain_reset(chain, &inverse, p);
    for (int k = 0; k < TICKS; k++) {
        const double hold = chain_equilibrium(chain, &plant);
        const double voltage =
            hold + random_between(seed, 0.1, 3.0) * (plant.core.y < 8.0 ? 1.0 : -1.0);
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

static void tangent(const struct chain *chain, map *f, struct chain_point d, double y, double input,
                    double d_y, double d_input)
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
        chain_prepare(&chain, &p);
        /* within the range and beyond its ends */
        const double y = i % 3 == 0 ? random_between(&seed, 1.0, 15.0)
                                    : random_between(&seed, 0.5, 60.0) * (i % 3 == 1 ? -1.0 : 1.0) +
                                          (i % 3 == 1 ? 0.0 : 16.0);
        const double aim = random_between(&seed, 1.0, 15.0);
        const double d_y = random_between(&seed, -1.0, 1.0), d_input = random_between(&seed, -1.0, 1.0);
        const struct chain_state state = { .core = { y } }, d_state = { .core = { d_y } };
        tangent(&chain, step_map, chain_step_tangent(&chain, &state, 50.0, &REST, d_state, d_input, &STILL), y, 50.0,
                d_y, d_input);
        tangent(&chain, inverse_map, chain_inverse_tangent(&chain, &state, aim, &REST, d_state, d_input, &STILL), y,
                aim, d_y, d_input);
        /* out of reach the reference no longer matters */
        tangent(&chain, inverse_map, chain_inverse_tangent(&chain, &state, 17.0, &REST, d_state, d_input, &STILL), y,
                17.0, d_y, d_input);
    }
}

static double hold_voltage(const struct chain_parameters *p)
{
    struct chain chain;
    struct chain_state state;

    chain_prepare(&chain, p);
    chain_reset(&chain, &state, p);
    return chain_equilibrium(&chain, &state);
}

/* The parameters that the equilibrium depends on: initialDisplacement, the ends and those of the rules. */
static double *parameter(struct chain_parameters *p, int i)
{
    double *const first[] = { &p->initialDisplacement, &p->displacementMin, &p->displacementMax };

    return i < 3 ? first[i] : (double *)(void *)p->rule + (i - 3);
}

static void equilibrium_tangent(double start)
{
    struct chain_parameters p;
    struct chain chain;
    struct chain_state state;

    table_1(&p);
    p.initialDisplacement = start;
    chain_prepare(&chain, &p);
    chain_reset(&chain, &state, &p);
    CHECK_CLOSE(chain_step(&chain, &state, hold_voltage(&p), &REST), p.initialDisplacement, 1e-13);
    chain_reset(&chain, &state, &p);
    for (int i = 0; i < 3 + 3 * IT2_RULE_PARAMETERS; i++) {
        struct chain_parameters d = { .sampleTime = 0.0 }, up = p, down = p;
        const double h = 1e-5 * fmax(0.1, fabs(*parameter(&p, i)));
        *parameter(&d, i) = 1.0;
        *parameter(&up, i) += h;
        *parameter(&down, i) -= h;
        const double slope = (hold_voltage(&up) - hold_voltage(&down)) / (2.0 * h);
        CHECK_NEAR(chain_equilibrium_tangent(&chain, &state, &p, &d), slope, fmax(1.0, fabs(slope)),
                   1e-6);
    }
}

int main(void)
{
    identity();
    no_wind_up();
    tangents();
    equilibrium_tangent(1.0);
    equilibrium_tangent(-30.0);
    equilibrium_tangent(70.0);
    return check_report("chain");
}
