/* it2_check and chain_check: what is refused, and that the message names the culprit. */
#include "chain.h"
#include "check.h"
#include "sets.h"

CHECK_MAIN;

static char message[512];

static bool usable(const struct it2_rule *rules, int count, double minimum, double maximum)
{
    message[0] = '\0';
    return it2_check(rules, count, (struct it2_range){ minimum, maximum }, message, sizeof message);
}

static bool says(const char *text)
{
    const bool found = strstr(message, text) != NULL;

    if (!found)
        fprintf(stderr, "'%s' is not in: %s\n", text, message);
    return found;
}

/* Table 1 with one number of rule 2 replaced. */
static bool usable_with(size_t place, double value)
{
    struct it2_rule rules[3];

    memcpy(rules, TABLE_1, sizeof rules);
    memcpy((char *)&rules[1] + place * sizeof(double), &value, sizeof value);
    return usable(rules, 3, 0.0, 16.0);
}

static void numbers_of_a_rule(void)
{
    static const char *const name[] = { "rule[2].sigmaLower", "rule[2].sigmaUpper", "rule[2].centre",
                                        "rule[2].q1",         "rule[2].q2",         "rule[2].q3" };

    for (size_t i = 0; i < 6; i++) {
        CHECK(!usable_with(i, NAN) && says(name[i]) && says("finite"));
        CHECK(!usable_with(i, INFINITY) && says(name[i]) && says("finite"));
        CHECK(!usable_with(i, -INFINITY) && says(name[i]));
    }
    CHECK(!usable_with(0, 0.0) && says("rule[2].sigmaLower") && says("positive"));
    CHECK(!usable_with(0, -1.0) && says("rule[2].sigmaLower is -1"));
    CHECK(!usable_with(1, 2.5) && says("rule[2].sigmaUpper is 2.5") && says("rule[2].sigmaLower"));
    CHECK(usable_with(1, 2.5647)); /* equal deviations: a type-1 rule */
}

static void counts_and_ranges(void)
{
    struct it2_rule rules[IT2_MAX_RULES + 1];

    for (int l = 0; l <= IT2_MAX_RULES; l++)
        rules[l] = TABLE_1[1];
    CHECK(usable(rules, 1, 0.0, 16.0));
    CHECK(usable(rules, IT2_MAX_RULES, 0.0, 16.0));
    CHECK(!usable(rules, 0, 0.0, 16.0) && says("ruleCount is 0"));
    CHECK(!usable(rules, -1, 0.0, 16.0) && says("ruleCount is -1"));
    CHECK(!usable(rules, 17, 0.0, 16.0) && says("ruleCount is 17"));
    CHECK(!usable(TABLE_1, 3, 1.0, 1.0) && says("displacementMin") && says("displacementMax"));
    CHECK(!usable(TABLE_1, 3, 2.0, 1.0) && says("displacementMin"));
    CHECK(!usable(TABLE_1, 3, NAN, 1.0) && says("displacementMin"));
    CHECK(!usable(TABLE_1, 3, 0.0, INFINITY) && says("displacementMax"));
}

static void not_invertible(void)
{
    struct it2_rule rules[3];

    CHECK(!usable_with(4, -1.0) && says("q2") && says("displacement of"));
    memcpy(rules, TABLE_1, sizeof rules);
    for (int l = 0; l < 3; l++)
        rules[l].q2 = 0.0;
    CHECK(!usable(rules, 3, 0.0, 16.0) && says("q2"));
}

static void not_contracting(void)
{
    struct it2 stage;
    double where = -1.0;

    CHECK(!usable(TABLE_1, 3, 0.0, 20.0) && says("contraction") && says("q1"));
    CHECK(!usable_with(3, 1.3) && says("contraction"));
    it2_prepare(&stage, TABLE_1, 3, IT2_EVERYWHERE);
    const double contraction = it2_contraction(&stage, TABLE_1_RANGE, &where);
    CHECK(contraction > 0.9 && contraction < 1.0);
    CHECK(where >= 0.0 && where <= 16.0);
}

/* Where Table 1 stops contracting above its centre, found by bisection: a range that ends there is refused,
 * one that ends a rounding before is not. From 0.1 on, where a grid's last point does not round to its end. */
static void both_ends_are_looked_at(void)
{
    struct it2 stage;
    double below = 16.0;
    double above = 20.0;

    it2_prepare(&stage, TABLE_1, 3, IT2_EVERYWHERE);
    while (nextafter(below, above) < above) {
        const double middle = 0.5 * (below + above);
        *(it2_partials(&stage, middle, it2_solve(&stage, middle, middle)).dy < 1.0 ? &below : &above) = middle;
    }
    CHECK(below > 18.0 && above < 18.5);
    for (double minimum = 0.0; minimum < 1.0; minimum += 0.1) {
        CHECK(usable(TABLE_1, 3, minimum, below));
        CHECK(!usable(TABLE_1, 3, minimum, above) && says("contraction"));
    }
}

/* A rule too narrow for a grid is looked at all the same. */
static void narrow_rules(void)
{
    struct it2_rule rules[4];

    memcpy(rules, TABLE_1, sizeof TABLE_1);
    rules[3] = (struct it2_rule){ 1e-3, 1e-3, 8.03, 0.9, -1.0, 0.0 };
    CHECK(!usable(rules, 4, 0.0, 16.0) && says("q2") && says("8.02"));
    rules[3] = (struct it2_rule){ 1e-3, 1e-3, 8.03, 3.0, 0.015, 0.0 };
    CHECK(!usable(rules, 4, 0.0, 16.0) && says("contraction"));
}

/* A message is cut to the caller's buffer. */
static void short_buffer(void)
{
    char small[8] = "xxxxxxx";

    CHECK(!it2_check(TABLE_1, 0, TABLE_1_RANGE, small, sizeof small));
    CHECK(strcmp(small, "ruleCou") == 0);
}

static void chain_parameters(void)
{
    struct chain_parameters p = {
        .sampleTime = 1e-4, .voltageMax = 150.0, .displacementMax = 16.0, .ruleCount = 3
    };

    memcpy(p.rule, TABLE_1, sizeof TABLE_1);
    CHECK(chain_check(&p, message, sizeof message));
    p.sampleTime = 0.0;
    CHECK(!chain_check(&p, message, sizeof message) && says("sampleTime"));
    p.sampleTime = NAN;
    CHECK(!chain_check(&p, message, sizeof message) && says("sampleTime"));
    p.sampleTime = 1e-4;
    p.voltageMin = 150.0;
    CHECK(!chain_check(&p, message, sizeof message) && says("voltageMin") && says("voltageMax"));
    p.voltageMin = 0.0;
    p.rule[2].sigmaLower = -1.0;
    CHECK(!chain_check(&p, message, sizeof message) && says("rule[3].sigmaLower"));
    p.rule[2] = TABLE_1[2];
    p.initialDisplacement = 79.9;
    CHECK(chain_check(&p, message, sizeof message));
    p.initialDisplacement = 80.1;
    CHECK(!chain_check(&p, message, sizeof message) && says("initialDisplacement is 80.1") && says("0 to 16"));
    p.initialDisplacement = -64.1;
    CHECK(!chain_check(&p, message, sizeof message) && says("initialDisplacement"));
    p.initialDisplacement = 0.0;
    p.rule[2].sigmaLower = -1.0;
    p.ruleCount = 2; /* rules beyond the count are not looked at */
    CHECK(chain_check(&p, message, sizeof message));
}

int main(void)
{
    CHECK(usable(TABLE_1, 3, 0.0, 16.0));
    CHECK(usable(TABLE_1, 3, 0.0, 17.0));
    numbers_of_a_rule();
    counts_and_ranges();
    not_invertible();
    not_contracting();
    both_ends_are_looked_at();
    narrow_rules();
    short_buffer();
    chain_parameters();
    return check_report("check");
}
