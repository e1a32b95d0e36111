#include "it2_single.h"

#include <stdint.h>

union number {
    float value;
    int32_t bits;
};

/* Sums over the rules, weighted by f_l + F_l: of 1, of q1 y_{k-1} + q3 and of q2. */
struct sums {
    float weight;
    float free_response;
    float slope;
};

/* The memberships' exponents, the largest one subtracted. */
struct exponents {
    float lower[IT2_MAX_RULES];
    float upper[IT2_MAX_RULES];
};

/* 2^x for x <= 0: 2^n e^(r ln 2) with |r| <= 1/2, the second factor by its series to degree 7. */
static float power_of_two(float x)
{
    const float round_to_integer = 12582912.0f; /* 1.5 * 2^23 */
    const float clamped = x > -126.0f ? x : -126.0f;
    const float n = (clamped + round_to_integer) - round_to_integer;
    const float r = (clamped - n) * 0.693147181f;
    const union number power = { .bits = ((int32_t)n + 127) << 23 };
    float series = 1.98412698e-4f;

    series = series * r + 1.38888889e-3f;
    series = series * r + 8.33333333e-3f;
    series = series * r + 4.16666667e-2f;
    series = series * r + 1.66666667e-1f;
    series = series * r + 0.5f;
    series = series * r + 1.0f;
    series = series * r + 1.0f;
    return x > -126.0f ? power.value * series : 0.0f;
}

static void exponents_at(const struct it2_single *stage, float y, struct exponents *exponents)
{
    float square[IT2_MAX_RULES];
    float largest = -3.4e38f;

    for (int l = 0; l < stage->rules; l++) {
        const float distance = y - stage->centre[l];
        square[l] = distance * distance;
        const float upper = square[l] * stage->exponent[l][1];
        largest = upper > largest ? upper : largest;
    }
    for (int l = 0; l < stage->rules; l++) {
        exponents->lower[l] = square[l] * stage->exponent[l][0] - largest;
        exponents->upper[l] = square[l] * stage->exponent[l][1] - largest;
    }
}

static struct sums sum_rules(const struct it2_single *stage, float y)
{
    struct sums sums = { 0.0f, 0.0f, 0.0f };
    struct exponents exponents;

    exponents_at(stage, y, &exponents);
    for (int l = 0; l < stage->rules; l++) {
        const float weight = power_of_two(exponents.lower[l]) + power_of_two(exponents.upper[l]);
        sums.weight += weight;
        sums.free_response += (stage->q1[l] * y + stage->q3[l]) * weight;
        sums.slope += stage->q2[l] * weight;
    }
    return sums;
}

/* dy_k/dy_{k-1} where (10) rests at y under x. */
static float feedback(const struct it2_single *stage, float y, float x)
{
    const float two_ln_2 = 1.38629436f;
    struct exponents exponents;
    float sum = 0.0f;
    float weights = 0.0f;

    exponents_at(stage, y, &exponents);
    for (int l = 0; l < stage->rules; l++) {
        const float lower = power_of_two(exponents.lower[l]);
        const float upper = power_of_two(exponents.upper[l]);
        const float slope =
            two_ln_2 * (y - stage->centre[l]) * (lower * stage->exponent[l][0] + upper * stage->exponent[l][1]);
        const float excess = stage->q1[l] * y + (stage->q2[l] * x + stage->q3[l]) - y;
        sum += stage->q1[l] * (lower + upper) + slope * excess;
        weights += lower + upper;
    }
    return sum / weights;
}

static struct it2_single_end end_at(const struct it2_single *stage, float y)
{
    const struct sums sums = sum_rules(stage, y);
    const float x = (y * sums.weight - sums.free_response) / sums.slope;

    return (struct it2_single_end){ y, x, sums.slope / sums.weight, feedback(stage, y, x) };
}

/* The end that y lies beyond, or NULL. */
static const struct it2_single_end *beyond(const struct it2_single *stage, float y)
{
    return y < stage->lower.y ? &stage->lower : y > stage->upper.y ? &stage->upper : NULL;
}

void it2_single_prepare(struct it2_single *stage, const struct it2_rule *rules, int count,
                        struct it2_single_range range)
{
    const double log2_e = 1.4426950408889634;

    *stage = (struct it2_single){ .rules = count };
    for (int l = 0; l < count; l++) {
        const struct it2_rule *rule = &rules[l];
        stage->centre[l] = (float)rule->centre;
        stage->exponent[l][0] = (float)(-0.5 * log2_e / (rule->sigmaLower * rule->sigmaLower));
        stage->exponent[l][1] = (float)(-0.5 * log2_e / (rule->sigmaUpper * rule->sigmaUpper));
        stage->q1[l] = (float)rule->q1;
        stage->q2[l] = (float)rule->q2;
        stage->q3[l] = (float)rule->q3;
    }
    stage->lower = end_at(stage, range.minimum);
    stage->upper = end_at(stage, range.maximum);
}

float it2_single_step(const struct it2_single *stage, float y_previous, float x)
{
    const struct it2_single_end *end = beyond(stage, y_previous);

    if (end)
        return end->y + end->dx * (x - end->x) + end->dy * (y_previous - end->y);
    const struct sums sums = sum_rules(stage, y_previous);

    return (sums.free_response + sums.slope * x) / sums.weight;
}

float it2_single_inverse(const struct it2_single *stage, float y_previous, float y)
{
    const struct it2_single_end *end = beyond(stage, y_previous);

    if (end)
        return end->x + (y - end->y - end->dy * (y_previous - end->y)) / end->dx;
    const struct sums sums = sum_rules(stage, y_previous);

    return (y * sums.weight - sums.free_response) / sums.slope;
}
