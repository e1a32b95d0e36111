/* Beyond the ends of its range the core goes on as its linearisation there: a contraction that nothing can
 * make diverge, with an inverse and derivatives. Within it is (10) bit for bit. */
#include "chain.h"
#include "check.h"
#include "sets.h"

CHECK_MAIN;

enum { SETS = 400, MAX_PARAMETERS = IT2_RULE_PARAMETERS * IT2_MAX_RULES };

static const double FAR = 80.0; /* um beyond either end */

/* --- within -------------------------------------------------------------------------------------- */

static void within_it_is_10(void)
{
    struct it2_rule rules[IT2_MAX_RULES];
    struct it2 everywhere, limited;
    double a[MAX_PARAMETERS], b[MAX_PARAMETERS];
    struct it2_partials by_a, by_b;
    uint64_t seed = 3;

    for (int i = 0; i < SETS; i++) {
        const int count = random_usable_rules(&seed, rules);
        it2_prepare(&everywhere, rules, count, IT2_EVERYWHERE);
        it2_prepare(&limited, rules, count, TABLE_1_RANGE);
        for (int k = -2; k < 100; k++) {
            const double y = k == -2 ? 0.0 : k == -1 ? 16.0 : random_between(&seed, 0.0, 16.0);
            const double x = random_between(&seed, -2000.0, 2000.0);
            CHECK(it2_evaluate(&limited, y, x) == it2_evaluate(&everywhere, y, x));
            CHECK(it2_solve(&limited, y, x) == it2_solve(&everywhere, y, x));
            CHECK(it2_gradient(&limited, y, x, a, &by_a) == it2_gradient(&everywhere, y, x, b, &by_b));
            CHECK(memcmp(a, b, sizeof *a * IT2_RULE_PARAMETERS * (size_t)count) == 0);
            CHECK(by_a.dx == by_b.dx && by_a.dy == by_b.dy && by_a.end == 0.0);
        }
    }
}

/* --- beyond -------------------------------------------------------------------------------------- */

struct case_beyond {
    struct it2_rule rules[IT2_MAX_RULES];
    int count;
    struct it2 everywhere, limited;
    double end, y, x;
};

/* A random set, and a random point beyond one of its ends. */
static void draw(uint64_t *seed, int i, struct case_beyond *c)
{
    if (i < 20) {
        c->count = 3;
        memcpy(c->rules, TABLE_1, sizeof TABLE_1);
    } else {
        c->count = random_usable_rules(seed, c->rules);
    }
    it2_prepare(&c->everywhere, c->rules, c->count, IT2_EVERYWHERE);
    it2_prepare(&c->limited, c->rules, c->count, TABLE_1_RANGE);
    c->end = i % 2 ? TABLE_1_RANGE.maximum : TABLE_1_RANGE.minimum;
    c->y = c->end + random_between(seed, 0.0, FAR) * (i % 2 ? 1.0 : -1.0);
    c->x = random_between(seed, -2000.0, 2000.0);
}

/* A(y_e) x + B(y_e) + s (y - y_e), from (10) itself. */
static void is_the_linearisation(const struct case_beyond *c)
{
    const double rest = it2_solve(&c->everywhere, c->end, c->end);
    const struct it2_partials f = it2_partials(&c->everywhere, c->end, rest);
    const double at_end = it2_evaluate(&c->everywhere, c->end, c->x);
    const double expected = at_end + f.dy * (c->y - c->end);
    const double size = fabs(at_end) + fabs(c->y) + fabs(f.dx * c->x) + fabs(f.dx * rest);
    const double y = it2_evaluate(&c->limited, c->y, c->x);

    CHECK_NEAR(y, expected, size, 1e-14);
    CHECK_NEAR(it2_solve(&c->limited, c->y, y), c->x, size / f.dx, 1e-14);
    CHECK(it2_partials(&c->limited, c->y, c->x).dx == f.dx);
    CHECK(it2_partials(&c->limited, c->y, c->x).dy == f.dy);
    CHECK(fabs(f.dy) < 1.0 && f.dx > 0.0);
}

/* Whatever the voltage is, nothing jumps at the end. */
static void joins(const struct case_beyond *c)
{
    const double outside = nextafter(c->end, c->y);
    const double size = fmax(16.0, fabs(0.03 * c->x));

    CHECK_NEAR(it2_evaluate(&c->limited, outside, c->x), it2_evaluate(&c->limited, c->end, c->x), size, 1e-13);
    CHECK_NEAR(it2_solve(&c->limited, outside, 8.0), it2_solve(&c->limited, c->end, 8.0), 1e4, 1e-12);
}

static double moved(const struct case_beyond *c, int parameter, double by)
{
    struct it2_rule rules[IT2_MAX_RULES];
    struct it2_range range = TABLE_1_RANGE;
    struct it2 stage;

    memcpy(rules, c->rules, sizeof rules);
    if (parameter >= 0)
        ((double *)(void *)rules)[parameter] += by;
    else
        *(c->y > 8.0 ? &range.maximum : &range.minimum) += by;
    it2_prepare(&stage, rules, c->count, range);
    return it2_evaluate(&stage, c->y, c->x);
}

/* What the rules and the end change there; against CasADi to rounding in tests/unit/test_range.py. */
static void derivatives(const struct case_beyond *c)
{
    const double h = 1e-5;
    double gradient[MAX_PARAMETERS];
    struct it2_partials f;

    CHECK(it2_gradient(&c->limited, c->y, c->x, gradient, &f) == it2_evaluate(&c->limited, c->y, c->x));
    for (int i = -1; i < IT2_RULE_PARAMETERS * c->count; i++) {
        const double difference = (moved(c, i, h) - moved(c, i, -h)) / (2.0 * h);
        CHECK_NEAR(i < 0 ? f.end : gradient[i], difference, fmax(1000.0, fabs(difference)), 1e-5);
    }
}

static void beyond(void)
{
    struct case_beyond c;
    uint64_t seed = 5;

    for (int i = 0; i < SETS; i++) {
        draw(&seed, i, &c);
        is_the_linearisation(&c);
        joins(&c);
        derivatives(&c);
    }
}

static void no_numbers(void)
{
    struct it2 stage;

    it2_prepare(&stage, TABLE_1, 3, TABLE_1_RANGE);
    CHECK(isnan(it2_evaluate(&stage, NAN, 50.0)));
    CHECK(isnan(it2_evaluate(&stage, 20.0, NAN)));
    CHECK(!isfinite(it2_evaluate(&stage, INFINITY, 50.0)));
    CHECK(isfinite(it2_evaluate(&stage, 1e300, 50.0)));
}

/* --- for good ------------------------------------------------------------------------------------ */

/* How far a run can come under voltages up to `voltage`: from within the range by one step, and beyond an
 * end by a geometric series. */
static double reach(const struct it2 *stage, double voltage)
{
    const struct it2_end *const ends[] = { &stage->lower, &stage->upper };
    double farthest = 0.0;

    for (int i = 0; i <= 1600; i++)
        for (int sign = -1; sign <= 1; sign += 2)
            farthest = fmax(farthest, fabs(it2_evaluate(stage, 0.01 * i, sign * voltage)));
    for (int e = 0; e < 2; e++) {
        const double step = ends[e]->dx * (voltage + fabs(ends[e]->x));
        farthest = fmax(farthest, fabs(ends[e]->y) + step / (1.0 - fabs(ends[e]->dy)));
    }
    return 1.01 * farthest + 16.0;
}

/* No voltage, no start and no set that passes the check makes a run diverge. */
static void stays_put(void)
{
    enum { TICKS = 2000 };
    struct it2_rule rules[IT2_MAX_RULES];
    struct it2 stage;
    struct it2_state state;
    uint64_t seed = 7;

    for (int i = 0; i < SETS; i++) {
        const bool paper = i % 4 == 0;
        const int count = paper ? 3 : random_usable_rules(&seed, rules);
        const double voltage = i % 2 ? 2000.0 : 220.0;
        const double constant = random_between(&seed, -voltage, voltage);
        it2_prepare(&stage, paper ? TABLE_1 : rules, count, TABLE_1_RANGE);
        const double bound = fmax(reach(&stage, voltage), FAR);
        it2_reset(&state, random_between(&seed, -FAR + 16.0, FAR));
        double largest = 0.0;
        for (int k = 0; k < TICKS; k++)
            largest = fmax(
                largest,
                fabs(it2_step(&stage, &state, i % 3 ? constant : random_between(&seed, -voltage, voltage))));
        CHECK(largest <= bound);  /* a NaN would stay out of the maximum ... */
        CHECK(isfinite(state.y)); /* ... but in the state */
        CHECK(!paper || largest < (i % 2 ? 26.0 : 5.0) * 16.0 + 1e-9);
    }
}

/* Under one constant voltage beyond the range all runs end in one place. */
static void forgets_its_start(void)
{
    const double voltage[] = { -500.0, 125.0, 150.0, 2000.0 };
    struct it2 stage;

    it2_prepare(&stage, TABLE_1, 3, TABLE_1_RANGE);
    for (size_t i = 0; i < sizeof voltage / sizeof voltage[0]; i++) {
        struct it2_state low = { -64.0 }, high = { 80.0 };
        for (int k = 0; k < 1000; k++) {
            it2_step(&stage, &low, voltage[i]);
            it2_step(&stage, &high, voltage[i]);
        }
        CHECK_NEAR(low.y, high.y, 16.0, 1e-12);
        CHECK(it2_beyond(&stage, low.y) == (voltage[i] < 0.0 ? &stage.lower : &stage.upper));
    }
}

int main(void)
{
    within_it_is_10();
    beyond();
    no_numbers();
    stays_put();
    forgets_its_start();
    return check_report("range");
}
