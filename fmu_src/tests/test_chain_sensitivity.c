/* The chain over a record: what it predicts is what chain_step gives, and its sensitivities are the
 * derivatives of that by everything that can be fitted. */
#include "chain_sensitivity.h"

#include <stddef.h>

#include "check.h"
#include "effect_sets.h"

CHECK_MAIN;

enum {
    SETS = 12,
    TICKS = 250,
    FIRST_TICK = 3000,
    MOST_COLUMNS = IT2_RULE_PARAMETERS * IT2_MAX_RULES + CHAIN_MAX_KNOBS
};

static const unsigned ALL = 2047;
static const double RANGE = 16.0;
#define STEP 2e-6      /* of a difference quotient, relative */
#define TOLERANCE 5e-5 /* relative; of the step's order where a limit engages within it */
#define NOISE 1e-14    /* rounding in a difference of two runs, of the largest displacement */

struct signals {
    double voltage[TICKS];
    double force[TICKS];
    double temperature[TICKS];
};

struct run {
    double measured[TICKS];
    double core_input[TICKS];
    double core_output[TICKS];
};

/* The rules' parameters first. */
struct columns {
    int count;
    size_t place[MOST_COLUMNS]; /* in struct chain_parameters */
    double step[MOST_COLUMNS];  /* of a difference quotient */
};

static double *value_at(struct chain_parameters *p, size_t offset)
{
    return (double *)(void *)((char *)p + offset);
}

static struct chain_record record_of(const struct signals *s)
{
    return (struct chain_record){ s->voltage, s->force, s->temperature, FIRST_TICK, TICKS };
}

static bool predict(const struct chain_parameters *p, const struct signals *signals, struct run *run)
{
    const struct chain_record record = record_of(signals);

    return CHECK(chain_predict(p, &record, run->measured, run->core_input, run->core_output) == TICKS);
}

/* --- sets ---------------------------------------------------------------------------------------- */

/* A random set that begins at rest at the returned voltage, within the amplifier's limits. */
static double random_set(uint64_t *seed, struct chain_parameters *p, unsigned effects)
{
    struct chain chain;
    struct chain_state state;

    plain(p);
    p->ruleCount = random_usable_rules(seed, p->rule);
    p->initialDisplacement = random_between(seed, 5.0, 9.0);
    add_effects(seed, p, effects & ~(unsigned)CHAIN_SATURATION);
    if (effects & CHAIN_PLAY) {
        p->initialDemagnetisation = random_between(seed, -40.0, 40.0);
        p->initialExcursion = random_between(seed, -30.0, 50.0);
    }
    if (effects & CHAIN_CREEP) {
        p->initialCreep = random_between(seed, -1.0, 1.0);
        p->initialCreepAge = 0.01 * fabs(p->initialCreep);
    }
    chain_prepare(&chain, p);
    chain_reset(&chain, &state, p);
    const double voltage = chain_equilibrium(&chain, &state);
    if (effects & CHAIN_SATURATION)
        p->saturation = (struct saturation_parameters){ voltage - random_between(seed, 3.0, 20.0),
                                                        voltage + random_between(seed, 3.0, 20.0) };
    return voltage;
}

static void signals_from(struct signals *s, double voltage)
{
    for (int k = 0; k < TICKS; k++) {
        const struct chain_surroundings around = surroundings(FIRST_TICK + k);
        s->voltage[k] = voltage + swing(-25.0, 25.0, k, 0.0);
        s->force[k] = around.force;
        s->temperature[k] = around.temperature;
    }
}

/* --- prediction ---------------------------------------------------------------------------------- */

static void is_the_chain(const struct chain_parameters *p, const struct signals *s)
{
    struct chain chain;
    struct chain_state state;
    struct run run;

    chain_prepare(&chain, p);
    it2_prepare(&chain.core, p->rule, p->ruleCount, IT2_EVERYWHERE);
    chain_reset(&chain, &state, p);
    if (!predict(p, s, &run))
        return;
    for (int k = 0; k < TICKS; k++) {
        const struct chain_surroundings around = surroundings(FIRST_TICK + k);
        const double y = chain_step(&chain, &state, s->voltage[k], &around);
        CHECK_NEAR(run.measured[k], chain_measure(&chain, y, around.time), RANGE, 1e-12);
        CHECK_NEAR(run.core_output[k], state.core.y, RANGE, 1e-12);
    }
}

/* --- sensitivities ------------------------------------------------------------------------------- */

/* Adds a row of parameters, but for those that are off. */
static void add(struct columns *c, struct chain_parameters *p, size_t first, int count)
{
    for (int i = 0; i < count; i++) {
        const size_t offset = first + (size_t)i * sizeof(double);
        const double step = STEP * fabs(*value_at(p, offset));
        if (step > 0.0) {
            c->place[c->count] = offset;
            c->step[c->count++] = step;
        }
    }
}

#define ADD(member) \
    add(c, p, offsetof(struct chain_parameters, member), (int)(sizeof p->member / (sizeof(double))))

/* All that can be fitted, first the rules' parameters. */
static void every_column(struct columns *c, struct chain_parameters *p)
{
    c->count = 0;
    add(c, p, offsetof(struct chain_parameters, rule), IT2_RULE_PARAMETERS * p->ruleCount);
    ADD(delay);
    ADD(slew);
    ADD(saturation);
    ADD(lag);
    ADD(play);
    ADD(initialDisplacement);
    ADD(initialDemagnetisation);
    ADD(initialExcursion);
    ADD(load);
    ADD(creep);
    ADD(initialCreep);
    ADD(initialCreepAge);
    ADD(displacementZero);
    ADD(resonance);
    ADD(drift);
    ADD(nonlinearity);
    ADD(hum);
}

/* Returns whether the column is far above what rounding makes of its difference quotient. */
static bool column_is_the_derivative(const struct chain_parameters *p, const struct signals *s, size_t place,
                                     double step, const double *column, int stride)
{
    struct chain_parameters changed = *p;
    struct run below, above;
    double largest = 0.0, deviation = 0.0, furthest = RANGE;

    *value_at(&changed, place) -= step;
    predict(&changed, s, &below);
    *value_at(&changed, place) += 2.0 * step;
    predict(&changed, s, &above);
    for (int k = 0; k < TICKS; k++) {
        const double slope = (above.measured[k] - below.measured[k]) / (2.0 * step);
        largest = fmax(largest, fabs(slope));
        deviation = fmax(deviation, fabs(column[(size_t)k * (size_t)stride] - slope));
        furthest = fmax(furthest, fabs(above.measured[k]));
    }
    const double rounding = NOISE * furthest / step;
    if (!CHECK(deviation <= TOLERANCE * largest + rounding))
        fprintf(stderr, "offset %zu: off by %g of %g, rounding %g\n", place, deviation, largest, rounding);
    return TOLERANCE * largest > rounding;
}

/* Returns the share of columns that could be told from rounding. */
static double are_the_derivatives(struct chain_parameters *p, const struct signals *s)
{
    static double sensitivity[TICKS * MOST_COLUMNS];
    struct columns c;
    struct run run;
    double measured[TICKS];
    const int rules = IT2_RULE_PARAMETERS * p->ruleCount;
    const struct chain_record record = record_of(s);
    int told = 0;

    every_column(&c, p);
    const size_t done =
        chain_sensitivity(p, &record, true, c.place + rules, c.count - rules, measured, sensitivity);
    CHECK(done == TICKS);
    predict(p, s, &run);
    for (int k = 0; k < TICKS; k++)
        CHECK_NEAR(measured[k], run.measured[k], RANGE, 1e-14);
    for (int j = 0; j < c.count; j++)
        told += column_is_the_derivative(p, s, c.place[j], c.step[j], sensitivity + j, c.count);
    return (double)told / c.count;
}

static void random_sets(unsigned effects)
{
    struct chain_parameters p;
    struct signals s;
    uint64_t seed = 23 + effects;
    double told = 0.0;

    for (int i = 0; i < SETS; i++) {
        signals_from(&s, random_set(&seed, &p, effects) + random_between(&seed, -4.0, 4.0));
        is_the_chain(&p, &s);
        told += are_the_derivatives(&p, &s);
    }
    CHECK(told > 0.8 * (double)SETS); /* the others are of rules that are far away */
}

int main(void)
{
    random_sets(0);
    for (unsigned effect = 1; effect < ALL; effect *= 2)
        random_sets(effect);
    random_sets(ALL);
    return check_report("chain_sensitivity");
}
