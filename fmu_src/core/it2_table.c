/* Makes the table of it2_table.h. */
#include "it2_table.h"

#include <string.h>

#include "it2_membership.h"

/* The first try is a width of at most this share of the smallest deviation. */
#define TABLE_WIDTHS_PER_DEVIATION 8

/* What an interpolation may be off by, in units of what it is added to: less than half a rounding error. */
#define TABLE_TOLERANCE (REAL_EPSILON / 4)

/* Terms as small as this are rounding errors of those that they were made of. */
#define TABLE_NOISE (2 * REAL_EPSILON)

/* Of widths from 0: beyond it, numbers of rows do not stand in the low bits. */
#define TABLE_FARTHEST 1e9

enum { TABLE_HALF = IT2_TABLE_TERMS / 2 };

#if !defined IT2HYS_SINGLE

/* Chebyshev nodes to the right of the middle, in widths, outermost first: cos((2 k + 1) pi / 16) / 2. */
static const real NODE[TABLE_HALF] = { 0.4903926402016152, 0.4157348061512726, 0.2777851165098011,
                                       0.09754516100806414 };

/* What is interpolated there is, in powers of the distance from the middle in widths, of even degree by sums
 * of what it is at a node and at the one opposite, and of odd degree by differences. */
static const real EVEN[TABLE_HALF][TABLE_HALF] = {
    { -0.02486404592245725, 0.08352232973991236, -0.18707572033318612, 0.628417436515731 },
    { 3.079206598101809, -10.207610470980601, 21.521318969965364, -14.39291509708657 },
    { -50.847802016127716, 154.75745324419754, -200.01228724013657, 96.10263601206675 },
    { 195.93391737092597, -473.0263206457788, 473.0263206457788, -195.93391737092597 },
};
static const real ODD[TABLE_HALF][TABLE_HALF] = {
    { -0.05070232275964601, 0.20090290373599667, -0.6734548009039408, 6.442323022705137 },
    { 6.279063643442639, -24.553177458195258, 77.4747014540141, -147.55129776142044 },
    { -103.68793869994184, 372.2504128939501, -720.0252114050161, 985.2117216160203 },
    { 399.5449794890307, -1137.8078372241453, 1702.8497659956126, -2008.648254265816 },
};

/* Chebyshev's polynomial of degree n, scaled to a width, begins with 2^(2 n - 1): what a term's coefficient
 * in these is, as long as the next but one is small beside it. */
static real chebyshev(real coefficient, int degree)
{
    return real_fabs(coefficient) / (real)(1 << (2 * degree - 1));
}

static real dot(const real a[TABLE_HALF], const real b[TABLE_HALF])
{
    return (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]);
}

/* A and B at y, by the rules. */
static void evaluate(const struct it2 *stage, real y, real value[2])
{
    struct it2_memberships m;

    value[0] = value[1] = 0;
    it2_memberships(stage, y, &m);
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        value[0] += rule->q2 * m.weight[l];
        value[1] += (rule->q1 * y + rule->q3) * m.weight[l];
    }
    value[0] /= m.sum;
    value[1] /= m.sum;
}

/* The terms for A or B, in widths, from what it is at nodes to the right and to the left; returns whether they
 * have converged for what is of the size `size`. */
static bool interpolate(const real right[TABLE_HALF], const real left[TABLE_HALF], real size,
                        real term[IT2_TABLE_TERMS])
{
    const real near = right[TABLE_HALF - 1]; /* only differences to it are small */
    real sum[TABLE_HALF], difference[TABLE_HALF];

    for (int k = 0; k < TABLE_HALF; k++) {
        sum[k] = (right[k] - near) + (left[k] - near);
        difference[k] = right[k] - left[k];
    }
    for (int j = 0; j < TABLE_HALF; j++) {
        term[2 * j] = dot(EVEN[j], sum);
        term[2 * j + 1] = dot(ODD[j], difference);
    }
    /* the next two terms, left out, fall short of the last two as these do of the two before */
    const real before = chebyshev(term[4], 4) + chebyshev(term[5], 5);
    const real last = chebyshev(term[6], 6) + chebyshev(term[7], 7);
    term[0] += near;
    return last <= TABLE_NOISE * size || last * last <= TABLE_TOLERANCE * size * before;
}

/* One row, around `middle`; returns whether it holds A and B to rounding. */
static bool make_row(const struct it2 *stage, real middle, real width, const real size[2],
                     real row[IT2_TABLE_TERMS][2])
{
    const real per_width = 1 / width;
    real right[2][TABLE_HALF], left[2][TABLE_HALF], value[2], term[IT2_TABLE_TERMS];
    bool converged = true;

    for (int k = 0; k < TABLE_HALF; k++) {
        evaluate(stage, middle + width * NODE[k], value);
        right[0][k] = value[0], right[1][k] = value[1];
        evaluate(stage, middle - width * NODE[k], value);
        left[0][k] = value[0], left[1][k] = value[1];
    }
    for (int i = 0; i < 2; i++) {
        real power = 1;
        converged &= interpolate(right[i], left[i], size[i], term);
        for (int j = 0; j < IT2_TABLE_TERMS; j++, power *= per_width)
            row[j][i] = term[j] * power;
    }
    return converged;
}

/* With intervals of a width, a power of two. */
static bool make_rows(struct it2_table *table, const struct it2 *stage, real width)
{
    const real low = table->range.minimum, high = table->range.maximum;
    const real length = real_fmax(real_fmax(real_fabs(low), real_fabs(high)), high - low);
    const real voltage = real_fmax(real_fabs(stage->lower.x), real_fabs(stage->upper.x));
    const real size[2] = { length / voltage, length };

    const real all = REAL(6755399441055744.0) * width;
    const real first = (low + all) - all;
    table->rounding = all - first;
    const int rows = (int)it2_table_row(high + table->rounding) + 1;
    for (int i = 0; i < rows; i++)
        if (!make_row(stage, first + (real)i * width, width, size, table->term[i]))
            return false;
    table->rows = rows;
    return true;
}

/* The largest power of two that is not larger. */
static real power_of_two(real value)
{
    real power = 1;

    while (power > value)
        power /= 2;
    while (2 * power <= value)
        power *= 2;
    return power;
}

static bool has_room(struct it2_range range, real width)
{
    const real farthest = real_fmax(real_fabs(range.minimum), real_fabs(range.maximum));

    return range.maximum - range.minimum <= (IT2_TABLE_ROWS - 2) * width && farthest <= TABLE_FARTHEST * width;
}

/* Finer and finer, as long as there is room. */
static void fill(struct it2_table *table, const struct it2 *stage)
{
    const real low = table->range.minimum, high = table->range.maximum;
    real deviation = high - low;

    table->rows = 0;
    for (int l = 0; l < stage->rules; l++)
        deviation = real_fmin(deviation, stage->rule[l].sigmaLower);
    if (!(deviation > 0 && isfinite(deviation)))
        return;
    for (real width = power_of_two(deviation / TABLE_WIDTHS_PER_DEVIATION); has_room(table->range, width);
         width /= 2)
        if (make_rows(table, stage, width))
            return;
}

static bool is_of(const struct it2_table *table, const struct it2 *stage)
{
    return table->rules == stage->rules && table->range.minimum == stage->plain.minimum &&
           table->range.maximum == stage->plain.maximum &&
           memcmp(table->rule, stage->rule, (size_t)stage->rules * sizeof *stage->rule) == 0;
}

bool it2_tabulate(struct it2 *stage, struct it2_table *table)
{
    if (!is_of(table, stage)) {
        table->rules = stage->rules;
        table->range = stage->plain;
        memcpy(table->rule, stage->rule, sizeof table->rule);
        fill(table, stage);
    }
    stage->table = table->rows > 0 ? table : NULL;
    return stage->table;
}

#else

bool it2_tabulate(struct it2 *stage, struct it2_table *table)
{
    (void)table;
    stage->table = NULL;
    return false;
}

#endif
