/* The effects as stages of the chain: off they are not there, inverse of step is the identity, tangents
 * are the derivatives, what is cut off does not wind up, a displacement is what the sensor reads, and
 * unusable parameters are named. */
#include "check.h"
#include "effect_sets.h"

CHECK_MAIN;

enum { SETS = 40, TICKS = 200 };

static const unsigned EVERY[] = { CHAIN_DELAY, CHAIN_SLEW,         CHAIN_SATURATION, CHAIN_LAG,
                                  CHAIN_PLAY,  CHAIN_LOAD,         CHAIN_CREEP,      CHAIN_RESONANCE,
                                  CHAIN_DRIFT, CHAIN_NONLINEARITY, CHAIN_HUM };
enum { EFFECTS = sizeof EVERY / sizeof EVERY[0] };
static const unsigned ALL = 2047;
static const unsigned INVERTIBLE =
    CHAIN_LAG | CHAIN_PLAY | CHAIN_LOAD | CHAIN_CREEP | CHAIN_RESONANCE | CHAIN_DRIFT | CHAIN_NONLINEARITY;

static bool prepare(struct chain *chain, const struct chain_parameters *p)
{
    char message[512] = "";
    const bool ok = chain_check(p, message, sizeof message);

    if (!CHECK(ok))
        fprintf(stderr, "%s\n", message);
    chain_prepare(chain, p);
    return ok;
}

/* --- off ---------------------------------------------------------------------------------------- */

static void off_is_the_core(void)
{
    struct chain_parameters p;
    struct chain chain;
    struct chain_state state;
    struct it2_state core;
    unsigned limits;

    plain(&p);
    p.voltageMin = -1e4, p.voltageMax = 1e4;
    p.hum.frequency = 50.0, p.resonance.damping = 0.1, p.play[0].weight = 1.0; /* of effects that are off */
    prepare(&chain, &p);
    CHECK(chain.effects == 0 && chain.reading == 0);
    chain_reset(&chain, &state, &p);
    it2_reset(&core, 5.0);
    for (int k = 0; k < TICKS; k++) {
        const struct chain_surroundings around = surroundings(k);
        const double u = swing(0.0, 120.0, k, 0.0);
        const double y = chain_step(&chain, &state, u, &around);
        CHECK(y == it2_step(&chain.core, &core, u) && y == chain_measure(&chain, y, around.time));
        const double aim = swing(1.0, 15.0, k, 0.0);
        const double x = chain_inverse(&chain, &state, aim, &around, &limits);
        CHECK(x == it2_inverse(&chain.core, &core, aim) && limits == 0);
    }
}

/* Each effect that is on shows. */
static void on_is_not(void)
{
    for (int e = 0; e < EFFECTS; e++) {
        struct chain_parameters p, without;
        struct chain chain, core;
        struct chain_state state, core_state;
        uint64_t seed = 5;
        double difference = 0.0;

        plain(&without);
        p = without;
        add_effects(&seed, &p, EVERY[e]);
        prepare(&chain, &p);
        prepare(&core, &without);
        CHECK((chain.effects | chain.reading) == EVERY[e]);
        chain_reset(&chain, &state, &p);
        chain_reset(&core, &core_state, &without);
        for (int k = 0; k < TICKS; k++) {
            const struct chain_surroundings around = surroundings(k);
            const double u = swing(0.0, 120.0, k, 0.0);
            const double y = chain_step(&chain, &state, u, &around);
            difference = fmax(difference, fabs(chain_measure(&chain, y, around.time) -
                                               chain_step(&core, &core_state, u, &around)));
        }
        CHECK(difference > 1e-3);
    }
}

static long met; /* ticks at which a reference was reached */

/* --- inverse ------------------------------------------------------------------------------------ */

static void inverse_then_step(uint64_t *seed, unsigned effects)
{
    struct chain_parameters p;
    struct chain chain;
    struct chain_state plant, inverse;
    unsigned limits;

    plain(&p);
    add_effects(seed, &p, effects);
    if (!prepare(&chain, &p))
        return;
    chain_reset(&chain, &plant, &p);
    chain_reset(&chain, &inverse, &p);
    for (int k = 0; k < TICKS; k++) {
        const struct chain_surroundings around = surroundings(k);
        const double fade = 1.0 - exp(-0.01 * k * k); /* from rest: a jump would leave the range */
        const double reference = 5.0 + fade * (swing(5.0, 9.0, k, 0.0) - 5.0);
        const double voltage = chain_inverse(&chain, &inverse, reference, &around, &limits);
        const double reached = chain_step(&chain, &plant, voltage, &around);
        CHECK(voltage >= p.voltageMin && voltage <= p.voltageMax);
        if (!limits) {
            CHECK_CLOSE(reached, reference, 1e-9);
            CHECK_NEAR(plant.core.y, inverse.core.y, 16.0, 1e-9);
            met++;
        }
    }
}

/* The plant's own displacement asks for nothing that is out of reach. */
static void step_then_inverse(uint64_t *seed, unsigned effects)
{
    struct chain_parameters p;
    struct chain chain;
    struct chain_state plant, inverse;
    unsigned limits;

    plain(&p);
    p.displacementMax = 17.0;
    p.displacementMin = -1.0;
    add_effects(seed, &p, effects);
    if (!prepare(&chain, &p))
        return;
    chain_reset(&chain, &plant, &p);
    chain_reset(&chain, &inverse, &p);
    for (int k = 0; k < TICKS; k++) {
        const struct chain_surroundings around = surroundings(k);
        const double voltage = swing(50.0, 60.0, k, 0.0);
        const double y = chain_step(&chain, &plant, voltage, &around);
        const double back = chain_inverse(&chain, &inverse, y, &around, &limits);
        CHECK(limits == 0);
        CHECK_NEAR(back, voltage, 100.0, 1e-9);
    }
}

static void identity(void)
{
    uint64_t seed = 3;

    for (int i = 0; i < SETS; i++) {
        for (int e = 0; e < EFFECTS; e++)
            if (EVERY[e] & INVERTIBLE) {
                inverse_then_step(&seed, EVERY[e]);
                step_then_inverse(&seed, EVERY[e]);
            }
        inverse_then_step(&seed, INVERTIBLE | CHAIN_HUM);
        step_then_inverse(&seed, INVERTIBLE);
        inverse_then_step(&seed, INVERTIBLE | CHAIN_SLEW | CHAIN_SATURATION);
    }
    CHECK(met > 6L * SETS * TICKS * 8 / 10);
}

/* --- what is cut off ---------------------------------------------------------------------------- */

/* Whatever the reference, the inverse's state is the plant's: nothing winds up. */
static void no_wind_up(uint64_t *seed)
{
    const double wild[] = { 3.0, 25.0, 1e4, -1e4, 14.0, 14.0, 14.0, 0.0, 16.0, 8.0 };
    const unsigned effects = INVERTIBLE | CHAIN_SLEW | CHAIN_SATURATION;
    struct chain_parameters p;
    struct chain chain;
    struct chain_state plant, inverse;
    unsigned limits, seen = 0;

    plain(&p);
    add_effects(seed, &p, effects);
    if (!prepare(&chain, &p))
        return;
    chain_reset(&chain, &plant, &p);
    chain_reset(&chain, &inverse, &p);
    for (int k = 0; k < TICKS; k++) {
        const struct chain_surroundings around = surroundings(k);
        const double held = inverse.slew.y;
        const double voltage = chain_inverse(&chain, &inverse, wild[k / 20], &around, &limits);
        chain_step(&chain, &plant, voltage, &around);
        seen |= limits;
        CHECK(k == 0 || fabs(voltage - held) <= p.slew.rate * p.sampleTime * (1.0 + 1e-12));
        for (int j = 0; j < p.playCount; j++)
            CHECK_NEAR(plant.play.p[j], inverse.play.p[j], 100.0, 1e-9);
        for (int i = 0; i < p.creepCount; i++)
            CHECK_NEAR(plant.creep.s[i], inverse.creep.s[i], 16.0, 1e-9);
        CHECK_NEAR(plant.core.y, inverse.reached.core.y, 16.0, 1e-9);
        CHECK_NEAR(plant.lag.y, inverse.reached.lag.y, 100.0, 1e-9);
        CHECK_NEAR(plant.resonance.y1, inverse.reached.resonance.y1, 16.0, 1e-9);
        CHECK_NEAR(plant.resonance.x1, inverse.reached.resonance.x1, 16.0, 1e-9);
        CHECK_NEAR(plant.slew.y, inverse.slew.y, 100.0, 1e-9);
    }
    CHECK(seen & CHAIN_REFERENCE_RANGE && seen & CHAIN_AMPLIFIER && seen & CHAIN_RETURNING);
}

/* Back within reach the limits are left at once, and the plant comes back by its own contraction; until it
 * is back the inverse says so. */
static void recovers(void)
{
    const struct chain_surroundings around = { 0.0, 293.15, 0.0 };
    struct chain_parameters p;
    struct chain chain;
    struct chain_state plant, inverse;
    unsigned limits;

    plain(&p);
    p.saturation = (struct saturation_parameters){ 0.0, 55.0 };
    p.slew.rate = 1e4;
    p.lag.timeConstant = 5e-4;
    p.playCount = 1;
    p.play[0] = (struct play_element){ 5.0, 0.5 };
    prepare(&chain, &p);
    chain_reset(&chain, &plant, &p);
    chain_reset(&chain, &inverse, &p);
    for (int k = 0; k < 3000; k++) {
        const double reference = k < 1500 ? 15.9 : 8.0;
        const double voltage = chain_inverse(&chain, &inverse, reference, &around, &limits);
        const double reached = chain_step(&chain, &plant, voltage, &around);
        CHECK(voltage <= 55.0 + 1e-9);
        if (k > 1000 && k < 1500)
            CHECK(limits == (CHAIN_AMPLIFIER | CHAIN_RETURNING) && voltage == 55.0 && reached < 15.0);
        if (k > 1600)
            CHECK(!(limits & CHAIN_AMPLIFIER));
        if (k > 2000)
            CHECK(limits == 0);
        if (!limits && k > 1500)
            CHECK_CLOSE(reached, 8.0, 1e-9);
    }
}

/* Whatever the limits and the reference, with steps, noise and parts out of reach: the voltage stays within
 * both its limits and the amplifier's, the plant is at the reference wherever the inverse does not say
 * otherwise, and that does not last: no limit cycle. */
static void within_the_voltages(uint64_t *seed, unsigned effects)
{
    const struct chain_surroundings around = { 0.0, 293.15, 0.0 };
    struct chain_parameters p;
    struct chain chain;
    struct chain_state plant, inverse;
    unsigned limits = 0;
    double reference = 5.0;
    enum { CALM = 30000 };

    plain(&p);
    add_effects(seed, &p, effects);
    p.saturation.minimum = fmin(p.saturation.minimum, 10.0);
    p.resonance.damping = fmax(p.resonance.damping, 0.05);
    p.drift.rate = 0.0;
    p.voltageMin = random_between(seed, -10.0, 12.0);
    p.voltageMax = random_between(seed, 75.0, 90.0);
    if (!prepare(&chain, &p))
        return;
    chain_reset(&chain, &plant, &p);
    chain_reset(&chain, &inverse, &p);
    for (int k = 0; k < 1000 + CALM; k++) {
        if (k % 100 == 0 && k < 1000)
            reference = random_between(seed, -4.0, 20.0);
        if (k == 1000)
            reference = random_between(seed, 6.0, 8.0);
        const double noise = k / 100 % 4 == 3 && k < 1000 ? random_between(seed, -0.3, 0.3) : 0.0;
        const double voltage = chain_inverse(&chain, &inverse, reference + noise, &around, &limits);
        const double reached = chain_step(&chain, &plant, voltage, &around);
        CHECK(voltage >= p.voltageMin && voltage <= p.voltageMax);
        CHECK(!(chain.effects & CHAIN_SATURATION) || k < 100 ||
              (voltage >= p.saturation.minimum - 1e-9 && voltage <= p.saturation.maximum + 1e-9));
        CHECK(!chain.effects || chain_is_astray(&inverse) == ((limits & CHAIN_RETURNING) != 0));
        if (!limits)
            CHECK_NEAR(reached, reference + noise, 16.0, 1e-9);
    }
    CHECK(!limits);
}

static void stays_within_the_voltages(uint64_t *seed)
{
    for (int i = 0; i < SETS; i++) {
        within_the_voltages(seed, INVERTIBLE | CHAIN_SLEW | CHAIN_SATURATION);
        within_the_voltages(seed, EVERY[i % EFFECTS] & ~(unsigned)CHAIN_DELAY);
        within_the_voltages(seed, (INVERTIBLE & ~EVERY[i % EFFECTS]) | CHAIN_SLEW);
    }
}

/* A run that rests beyond the voltages, farther than the slew limit lets it come back in a tick. */
static void begins_beyond_the_voltages(void)
{
    const struct chain_surroundings around = { 0.0, 293.15, 0.0 };
    struct chain_parameters p;
    struct chain chain;
    struct chain_state plant, inverse;
    unsigned limits;

    plain(&p);
    p.voltageMin = 40.0;
    p.slew.rate = 2e3;
    prepare(&chain, &p);
    chain_reset(&chain, &plant, &p);
    chain_reset(&chain, &inverse, &p);
    CHECK(chain_hold(&chain, &inverse) < 35.0 && chain_equilibrium(&chain, &inverse) == 40.0);
    for (int k = 0; k < 2000; k++) {
        const double voltage = chain_inverse(&chain, &inverse, 9.0, &around, &limits);
        const double reached = chain_step(&chain, &plant, voltage, &around);
        CHECK(voltage >= 40.0);
        CHECK_NEAR(plant.slew.y, inverse.slew.y, 1.0, 1e-12);
        CHECK(k > 20 || limits);
        if (!limits)
            CHECK_CLOSE(reached, 9.0, 1e-9);
    }
    CHECK(!limits);
}

/* --- the static curve ---------------------------------------------------------------------------- */

/* Of the curve at an end. */
static double nonlinearity_slope_at(const struct nonlinearity *curve, double end)
{
    const struct nonlinearity_parameters *c = &curve->coefficient;
    const double inner = c->quadratic + end * c->cubic + c->quartic + end * c->quintic + c->sextic;

    return 1.0 - 2.0 * end * inner / curve->half_range;
}

/* To rounding, wherever the curve rises: flat parts and steep ones beyond the ends, too. */
static void curve_and_back(void)
{
    const struct stage *stage = &nonlinearity_stage;
    struct chain_parameters p = { .sampleTime = 1e-4 };
    struct nonlinearity curve;
    uint64_t seed = 41;
    char message[512];
    long curves = 0;

    while (curves < 2000) {
        const double size = pow(10.0, random_between(&seed, -3.0, 0.7));
        p.nonlinearity = (struct nonlinearity_parameters){ random_between(&seed, -size, size),
                                                           random_between(&seed, -size, size),
                                                           random_between(&seed, -size, size),
                                                           random_between(&seed, -size, size),
                                                           random_between(&seed, -size, size),
                                                           -1.0,
                                                           15.0 };
        p.displacementZero = random_between(&seed, -3.0, 3.0);
        if (!nonlinearity_analysis.check(&p, message, sizeof message))
            continue;
        curves++;
        stage->prepare(&curve, &p);
        for (int i = -5; i <= 105; i++) {
            const double y = p.displacementZero - 1.0 + 0.16 * i;
            const double x = stage->inverse(&curve, NULL, y, NULL);
            CHECK_NEAR(stage->step(&curve, NULL, x, NULL), y, fmax(16.0, fabs(x)), 1e-15);
            /* beyond the ends on with the slope that the curve has there */
            const double end = p.displacementZero + (i < 50 ? -1.0 : 15.0);
            const double slope = nonlinearity_slope_at(&curve, i < 50 ? -1.0 : 1.0);
            if (i < 0 || i > 100)
                CHECK_NEAR((x - end) * slope, y - end, fmax(16.0, fabs(x)), 1e-15);
        }
    }
    p = (struct chain_parameters){ .nonlinearity = { .quadratic = 0.5, .maximum = 16.0 } };
    stage->prepare(&curve, &p);
    CHECK(isnan(stage->inverse(&curve, NULL, (double)NAN, NULL)));
    CHECK(stage->inverse(&curve, NULL, INFINITY, NULL) == INFINITY);
}

/* --- what a displacement is ----------------------------------------------------------------------- */

static void move(struct chain_parameters *p, double by)
{
    p->initialDisplacement += by;
    p->displacementMin += by;
    p->displacementMax += by;
    p->displacementZero += by;
    for (int l = 0; l < p->ruleCount; l++) {
        p->rule[l].centre += by;
        p->rule[l].q3 += by * (1.0 - p->rule[l].q1);
    }
}

/* A sensor's zero is arbitrary: another one moves what it reads, and nothing else. */
static void another_zero(uint64_t *seed, double by)
{
    struct chain_parameters p, moved;
    struct chain chain, other;
    struct chain_state plant, plant_moved, inverse, inverse_moved;
    unsigned limits, limits_moved;

    plain(&p);
    add_effects(seed, &p, ALL);
    p.initialCreep = random_between(seed, -1.0, 1.0);
    p.initialCreepAge = 0.01 * fabs(p.initialCreep);
    p.initialDemagnetisation = random_between(seed, -20.0, 20.0);
    moved = p;
    move(&moved, by);
    if (!prepare(&chain, &p) || !prepare(&other, &moved))
        return;
    chain_reset(&chain, &plant, &p);
    chain_reset(&chain, &inverse, &p);
    chain_reset(&other, &plant_moved, &moved);
    chain_reset(&other, &inverse_moved, &moved);
    CHECK_NEAR(chain_equilibrium(&other, &plant_moved), chain_equilibrium(&chain, &plant), 100.0, 1e-9);
    for (int k = 0; k < TICKS; k++) {
        const struct chain_surroundings around = surroundings(k);
        const double u = swing(0.0, 120.0, k, 0.0);
        const double y = chain_step(&chain, &plant, u, &around);
        CHECK_NEAR(chain_step(&other, &plant_moved, u, &around) - by, y, 16.0, 1e-11);
        const double aim = swing(5.0, 9.0, k, 0.0);
        const double x = chain_inverse(&chain, &inverse, aim, &around, &limits);
        CHECK_NEAR(chain_inverse(&other, &inverse_moved, aim + by, &around, &limits_moved), x, 100.0, 1e-6);
        CHECK(limits == limits_moved);
    }
}

/* --- before the start ----------------------------------------------------------------------------- */

/* Told nothing of its history, a stage is new and came straight from 0 V: it is on the initial loading curve.
 * Demagnetised or driven elsewhere, it is on a branch. */
static void history_is_walked(void)
{
    const struct stage *stage = &play_stage;
    struct chain_parameters p;
    struct play play;
    struct play_state state, there;
    uint64_t seed = 43;

    for (int i = 0; i < 200; i++) {
        plain(&p);
        add_effects(&seed, &p, CHAIN_PLAY);
        stage->prepare(&play, &p);
        const double h = random_between(&seed, -100.0, 100.0);
        const double x = stage->rest(&play, &state, h, &p);
        for (int j = 0; j < p.playCount; j++)
            CHECK(state.p[j] == copysign(fmax(fabs(x) - play.element[j].threshold, 0.0), x));
        CHECK_NEAR(stage->step(&play, &state, x, NULL), h, 100.0, 1e-13);
        /* the same as walked by the operators: demagnetised at 20 V, driven to 65 V, then to where it rests */
        const double rest = random_between(&seed, -30.0, 60.0);
        for (int j = 0; j < p.playCount; j++)
            state.p[j] = 20.0;
        stage->step(&play, &state, 65.0, NULL);
        const double walked = stage->step(&play, &state, rest, NULL);
        p.initialDemagnetisation = 20.0;
        p.initialExcursion = 45.0;
        CHECK_NEAR(stage->rest(&play, &there, walked, &p), rest, 100.0, 1e-13);
        for (int j = 0; j < p.playCount; j++)
            CHECK_NEAR(there.p[j], state.p[j], 100.0, 1e-13);
    }
}

/* Told the displacement alone, with the curve and creep in it, the chain stays there under the voltage that
 * holds it. */
static void rests_where_it_is_told(void)
{
    const struct chain_surroundings still = { 0.0, 293.15, 0.0 };
    uint64_t seed = 47;

    for (int i = 0; i < SETS; i++) {
        struct chain_parameters p;
        struct chain chain;
        struct chain_state state;
        plain(&p);
        add_effects(&seed, &p, INVERTIBLE & ~(unsigned)CHAIN_DRIFT);
        p.displacementZero = random_between(&seed, -3.0, 3.0);
        p.initialDisplacement = random_between(&seed, 3.0, 12.0);
        prepare(&chain, &p);
        chain_reset(&chain, &state, &p);
        const double hold = chain_equilibrium(&chain, &state);
        for (int k = 0; k < 50; k++)
            CHECK_CLOSE(chain_step(&chain, &state, hold, &still), p.initialDisplacement, 1e-11);
    }
}

/* plant(inverse(reference)) is the reference later; with it known ahead, on time. */
static void delayed(double ticks)
{
    struct chain_parameters p;
    struct chain chain;
    struct chain_state plant, inverse;
    const int whole = (int)ticks;
    unsigned limits;

    plain(&p);
    p.voltageMin = -1e4, p.voltageMax = 1e4; /* it is not about the jump at the start */
    p.delay.time = ticks * 1e-4;
    p.drift.rate = 3.0;
    prepare(&chain, &p);
    chain_reset(&chain, &plant, &p);
    chain_reset(&chain, &inverse, &p);
    for (int k = 0; k < TICKS; k++) {
        const struct chain_surroundings around = { 0.0, 293.15, 1e-4 * k };
        const double fade = 1.0 - exp(-0.01 * (k + whole) * (k + whole));
        const double ahead = 5.0 + fade * (swing(4.0, 9.0, k + whole, 0.0) - 5.0);
        const double fade_now = 1.0 - exp(-0.01 * k * k);
        const double now = 5.0 + fade_now * (swing(4.0, 9.0, k, 0.0) - 5.0);
        const double voltage = chain_inverse(&chain, &inverse, ahead, &around, &limits);
        const double reached = chain_step(&chain, &plant, voltage, &around);
        if (k > 2 * whole + 100)
            CHECK_NEAR(reached, now, 1.0, whole == ticks ? 1e-6 : 0.5);
    }
}

static void delay_taps(void)
{
    struct chain_parameters p = { .sampleTime = 1e-4 };
    struct delay delay;
    struct delay_state state;

    for (int ticks = 0; ticks <= DELAY_MAX_TICKS; ticks++)
        for (int half = 0; half <= (ticks < DELAY_MAX_TICKS); half++) {
            p.delay.time = 1e-4 * (ticks + 0.5 * half);
            delay_stage.prepare(&delay, &p);
            delay_stage.rest(&delay, &state, -1000.0, &p);
            for (int k = 0; k < 200; k++) {
                const double y = delay_stage.step(&delay, &state, 3.0 * k, NULL);
                if (k > ticks)
                    CHECK_NEAR(y, 3.0 * (k - ticks - 0.5 * half), 1.0, half ? 1e-9 : 0.0);
            }
        }
}

/* A state from elsewhere may say that the newest voltage is where none can be. */
static void delay_of_an_invented_state(void)
{
    static const double places[] = { -1.0, 5.0, 64.0, 1e300, -1e300, NAN, INFINITY };
    const struct chain_parameters p = { .sampleTime = 1e-4, .delay.time = 4e-4 };
    struct delay delay;
    struct delay_state state;

    delay_stage.prepare(&delay, &p);
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        delay_stage.rest(&delay, &state, 7.0, &p);
        state.newest = places[i];
        CHECK(delay_stage.step(&delay, &state, 9.0, NULL) == 7.0);
        CHECK(state.newest >= 0.0 && state.newest < 5.0);
    }
}

/* --- tangents ----------------------------------------------------------------------------------- */

struct variation {
    struct chain_state state;
    double input;
    struct chain_surroundings around;
};

static struct variation moved(const struct variation *at, const struct variation *d, double h)
{
    struct variation result = *at;
    double *to = (double *)(void *)&result;
    const double *by = (const double *)(const void *)d;

    for (size_t i = 0; i < sizeof result / sizeof *to; i++)
        to[i] += h * by[i];
    return result;
}

static struct chain_point value(const struct chain *chain, struct variation at, bool inverse)
{
    struct chain_point point = { .state = at.state };
    unsigned limits;

    point.output = inverse ? chain_inverse(chain, &point.state, at.input, &at.around, &limits)
                           : chain_step(chain, &point.state, at.input, &at.around);
    return point;
}

/* Second differences tell a corner apart, where there is no derivative; returns whether it was smooth. */
static bool tangent_is_difference(const struct chain *chain, const struct variation *at,
                                  const struct variation *d, bool inverse)
{
    const double h = 1e-5;
    const struct chain_point up = value(chain, moved(at, d, h), inverse);
    const struct chain_point down = value(chain, moved(at, d, -h), inverse);
    const struct chain_point here = value(chain, *at, inverse);
    const struct chain_point t =
        inverse
            ? chain_inverse_tangent(chain, &at->state, at->input, &at->around, d->state, d->input, &d->around)
            : chain_step_tangent(chain, &at->state, at->input, &at->around, d->state, d->input, &d->around);
    const double *a = (const double *)(const void *)&up, *b = (const double *)(const void *)&down;
    const double *c = (const double *)(const void *)&here, *e = (const double *)(const void *)&t;
    double bend = 0.0;

    for (size_t i = 0; i < sizeof t / sizeof *e; i++)
        bend = fmax(bend, fabs(a[i] - 2.0 * c[i] + b[i]) / h);
    if (bend > 4e-5) /* a corner within the step adds half of it to the slope */
        return false;
    for (size_t i = 0; i < sizeof t / sizeof *e; i++) {
        const double slope = (a[i] - b[i]) / (2.0 * h);
        CHECK_NEAR(e[i], slope, fmax(1.0, fabs(slope)), 2e-5);
    }
    return true;
}

static void random_direction(uint64_t *seed, const struct chain *chain, const struct variation *at,
                             struct variation *d)
{
    double *by = (double *)(void *)d;

    *d = (struct variation){ .input = 0.0 };
    for (size_t i = 0; i < sizeof *d / sizeof *by; i++)
        by[i] = random_between(seed, -1.0, 1.0);
    d->around.time = 0.0;
    if (!chain->effects) { /* the core's state only is in use */
        const double y = d->state.core.y;
        d->state = (struct chain_state){ .core = { y } };
    }
    if (!chain_is_astray(&at->state)) /* nor does it go astray by itself */
        d->state.reached = (struct chain_reached){ d->state.core, d->state.lag, d->state.resonance };
}

static void tangents_of(uint64_t *seed, unsigned effects, long *smooth, long *astray)
{
    struct chain_parameters p;
    struct chain chain;
    struct variation at, d;

    plain(&p);
    add_effects(seed, &p, effects);
    if (!prepare(&chain, &p))
        return;
    chain_reset(&chain, &at.state, &p);
    struct variation backward = at;
    for (int k = 0; k < 60; k++) {
        at.around = backward.around = surroundings(k);
        at.input = swing(-20.0, 120.0, 3 * k, 0.0);
        random_direction(seed, &chain, &at, &d);
        *smooth += tangent_is_difference(&chain, &at, &d, false);
        const double y = chain_step(&chain, &at.state, at.input, &at.around);
        /* gently, with a jump out of reach now and then: astray for some ticks, back for others */
        backward.input = k % 20 == 5 ? 30.0 : y + random_between(seed, -0.02, 0.02);
        random_direction(seed, &chain, &backward, &d);
        *smooth += tangent_is_difference(&chain, &backward, &d, true);
        *astray += chain_is_astray(&backward.state);
        unsigned limits;
        chain_inverse(&chain, &backward.state, backward.input, &backward.around, &limits);
    }
}

static void tangents(void)
{
    uint64_t seed = 11;
    long smooth = 0, astray = 0;
    const long all = 2 * 60 * 10 * 12;

    for (int i = 0; i < 10; i++) {
        for (int e = 0; e < EFFECTS; e++)
            tangents_of(&seed, EVERY[e], &smooth, &astray);
        tangents_of(&seed, ALL, &smooth, &astray);
    }
    CHECK(smooth > all * 9 / 10);
    CHECK(astray > all / 20 && astray < all / 2 * 19 / 20);
}

static double bend(const struct chain_parameters *p, double y)
{
    struct nonlinearity curve;

    nonlinearity_stage.prepare(&curve, p);
    return nonlinearity_stage.step(&curve, NULL, y, NULL);
}

static void curve_tangent(void)
{
    struct chain_parameters p;
    struct nonlinearity curve;

    plain(&p);
    p.displacementZero = 1.0;
    p.nonlinearity = (struct nonlinearity_parameters){ 0.5, -0.4, 0.3, -0.2, 0.1, -1.0, 15.0 };
    nonlinearity_stage.prepare(&curve, &p);
    for (double y = -3.0; y < 19.0; y += 0.37) {
        const double slope = (bend(&p, y + 1e-6) - bend(&p, y - 1e-6)) / 2e-6;
        double row[] = { 2.0, 1.0 };
        nonlinearity_analysis.tangent(&curve, NULL, y, NULL, NULL, 2, NULL, row);
        CHECK_NEAR(row[0], 2.0 * slope, 1.0, 1e-6);
        CHECK(slope > 0.0 && row[1] == 0.5 * row[0]);
    }
    CHECK(bend(&p, 0.0) == 0.0 && bend(&p, 16.0) == 16.0);
}

static void equilibrium(void)
{
    uint64_t seed = 23;

    for (int i = 0; i < SETS; i++) {
        struct chain_parameters p;
        struct chain chain;
        struct chain_state state;
        plain(&p);
        add_effects(&seed, &p, i % 2 ? CHAIN_PLAY | CHAIN_CREEP : ALL & ~(unsigned)CHAIN_DRIFT);
        if (i % 5 == 4) /* it rests beyond */
            p.voltageMax = 5.0;
        if (i % 3 == 2) { /* not from long rest where it is */
            p.initialDemagnetisation = random_between(&seed, -30.0, 50.0);
            p.initialExcursion = random_between(&seed, -50.0, 60.0);
            p.initialCreep = random_between(&seed, -2.0, 2.0);
            p.initialCreepAge = 0.01 * fabs(p.initialCreep);
        }
        prepare(&chain, &p);
        chain_reset(&chain, &state, &p);
        const double hold = hold_voltage(&p);
        const struct chain_surroundings still = { 0.0, 293.15, 0.0 };
        for (int k = 0; i % 2 && i % 3 < 2 && i % 5 < 4 && k < 20; k++)
            CHECK_CLOSE(chain_step(&chain, &state, hold, &still), 5.0, 1e-9);
        chain_reset(&chain, &state, &p);
        double *const moved_by[] = { &p.initialDisplacement, &p.play[0].weight,       &p.play[0].threshold,
                                     &p.creep[0].gain,       &p.rule[1].q3,           &p.initialDemagnetisation,
                                     &p.initialExcursion,    &p.initialCreep,         &p.initialCreepAge,
                                     &p.displacementZero,    &p.voltageMin,           &p.voltageMax,
                                     &p.saturation.minimum,  &p.saturation.maximum,   &p.nonlinearity.quadratic,
                                     &p.nonlinearity.cubic,  &p.nonlinearity.quartic, &p.nonlinearity.quintic,
                                     &p.nonlinearity.sextic, &p.nonlinearity.minimum, &p.nonlinearity.maximum };
        const size_t count = i % 2 ? 12 : 21; /* limits and curve, where there are any */
        for (size_t m = 0; m < count; m++) {
            struct chain_parameters d = { .sampleTime = 0.0 };
            *(double *)((char *)&d + ((char *)moved_by[m] - (char *)&p)) = 1.0;
            const double before = *moved_by[m], h = 1e-6;
            *moved_by[m] = before + h;
            const double up = hold_voltage(&p);
            *moved_by[m] = before - h;
            const double slope = (up - hold_voltage(&p)) / (2.0 * h);
            *moved_by[m] = before;
            CHECK_NEAR(chain_equilibrium_tangent(&chain, &state, &p, &d), slope, fmax(1.0, fabs(slope)), 1e-5);
        }
    }
}

/* --- checks ------------------------------------------------------------------------------------- */

static void refused(struct chain_parameters p, const char *name)
{
    char message[512] = "";

    CHECK(!chain_check(&p, message, sizeof message));
    if (!CHECK(strstr(message, name) != NULL))
        fprintf(stderr, "'%s' is not in: %s\n", name, message);
}

static void checks(void)
{
    struct chain_parameters p;

#define REFUSED(change, name) plain(&p), change, refused(p, name)
    REFUSED(p.delay.time = -1e-4, "delay.time");
    REFUSED(p.delay.time = 65e-4, "64 ticks");
    REFUSED(p.slew.rate = -1.0, "slew.rate");
    REFUSED(p.saturation.minimum = 1.0, "saturation.minimum");
    REFUSED(p.saturation = ((struct saturation_parameters){ 5.0, 5.0 }), "saturation.minimum");
    REFUSED(p.lag.timeConstant = -1.0, "lag.timeConstant");
    REFUSED(p.lag.timeConstant = 1e6, "lag.timeConstant");
    REFUSED(p.playCount = PLAY_MAX + 1, "playCount");
    REFUSED((p.playCount = 1, p.play[0].threshold = -1.0), "play[1].threshold");
    REFUSED((p.playCount = 2, p.play[0].threshold = 2.0, p.play[1].threshold = 1.0), "play[2].threshold");
    REFUSED((p.playCount = 1, p.play[0].weight = -1.0), "play[1].weight");
    REFUSED((p.playCount = 2, p.play[0].weight = -0.5, p.play[1].weight = -0.6), "play[2].weight");
    REFUSED(p.load.compliance = -1e-3, "load.compliance");
    REFUSED(p.creepCount = -1, "creepCount");
    REFUSED(p.creepCount = 1, "creep[1].timeConstant");
    REFUSED((p.creepCount = 1, p.creep[0] = (struct creep_element){ -1.0, 1.0 }), "creep[1].gain");
    REFUSED(p.resonance.frequency = -5.0, "resonance.frequency");
    REFUSED(p.resonance.frequency = 5000.0, "Nyquist");
    REFUSED(p.resonance.frequency = 500.0, "resonance.damping");
    REFUSED((p.resonance.frequency = 500.0, p.resonance.damping = 1.0), "resonance.damping");
    REFUSED((p.resonance.frequency = 500.0, p.resonance.damping = 0.1, p.resonance.samplingZero = -1.0),
            "resonance.samplingZero");
    REFUSED((p.resonance.frequency = 500.0, p.resonance.damping = 0.1, p.resonance.samplingZero = 0.1),
            "resonance.samplingZero");
    REFUSED((p.resonance.frequency = 500.0, p.resonance.damping = 0.1, p.resonance.samplingDelay = -1e-5),
            "resonance.samplingDelay");
    REFUSED((p.resonance.frequency = 500.0, p.resonance.damping = 0.1, p.resonance.samplingDelay = 2.1e-4),
            "2 ticks");
    REFUSED(p.voltageMax = -50.0, "voltageMin");
    REFUSED((p.nonlinearity.quadratic = 9.0, p.nonlinearity.maximum = 16.0), "nonlinearity.quadratic");
    REFUSED(p.nonlinearity.quadratic = 9.0, "nonlinearity.minimum");
    REFUSED(p.hum.amplitude = -1.0, "hum.amplitude");
    REFUSED(p.hum.amplitude = 0.1, "hum.frequency");
    REFUSED(p.lag.timeConstant = (double)NAN, "lag.timeConstant");
    REFUSED(p.resonance.frequency = (double)NAN, "resonance.frequency");
}

int main(void)
{
    uint64_t seed = 29;

    off_is_the_core();
    on_is_not();
    identity();
    for (int i = 0; i < SETS; i++)
        no_wind_up(&seed);
    recovers();
    stays_within_the_voltages(&seed);
    begins_beyond_the_voltages();
    curve_and_back();
    another_zero(&seed, 250.0);
    another_zero(&seed, -100.0);
    for (int i = 0; i < SETS; i++)
        another_zero(&seed, random_between(&seed, -30.0, 30.0));
    history_is_walked();
    rests_where_it_is_told();
    delayed(0.0);
    delayed(3.0);
    delayed(17.0);
    delayed(2.5);
    delay_taps();
    delay_of_an_invented_state();
    tangents();
    curve_tangent();
    equilibrium();
    checks();
    return check_report("effects");
}
