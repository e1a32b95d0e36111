/* Parameter sets for tests: the paper's Table 1 in um and V, and random ones from a fixed seed. */
#ifndef IT2HYS_SETS_H
#define IT2HYS_SETS_H

#include <stdint.h>
#include <string.h>

#include "it2_table.h"

static const struct it2_rule TABLE_1[] = {
    { 4.3427, 17.8879, 0.0892, 0.8943, 0.0196, 1.7504 },
    { 2.5647, 11.5798, 8.6067, 0.9140, 0.0129, 0.8773 },
    { 2.1349, 19.8162, 18.7381, 1.1882, 0.0148, -6.2312 },
};
static const struct it2_range TABLE_1_RANGE = { 0.0, 16.0 };

/* Uniform in [low, high), the same on every machine (Knuth's MMIX generator). */
static inline double random_between(uint64_t *seed, double low, double high)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(*seed >> 11) / 9007199254740992.0;
}

static inline int random_count(uint64_t *seed)
{
    return 1 + (int)random_between(seed, 0.0, IT2_MAX_RULES);
}

/* Often, not always, usable over TABLE_1_RANGE. */
static inline void random_rules(uint64_t *seed, struct it2_rule *rules, int count)
{
    for (int l = 0; l < count; l++) {
        rules[l].sigmaLower = random_between(seed, 1.0, 8.0);
        rules[l].sigmaUpper = rules[l].sigmaLower * random_between(seed, 1.0, 4.0);
        rules[l].centre = random_between(seed, -2.0, 20.0);
        rules[l].q1 = random_between(seed, 0.8, 0.97);
        rules[l].q2 = random_between(seed, 0.005, 0.03);
        rules[l].q3 = random_between(seed, -0.2, 0.2);
    }
}

/* The next random set that it2_check accepts; returns its number of rules. */
static inline int random_usable_rules(uint64_t *seed, struct it2_rule *rules)
{
    char message[512];
    int count;

    do {
        count = random_count(seed);
        random_rules(seed, rules, count);
    } while (!it2_check(rules, count, TABLE_1_RANGE, message, sizeof message));
    return count;
}

#endif
