/* exponential.h in single precision: exp(x) = 2^n e^(r ln 2) with the integer n next to the argument, which
 * comes multiplied by 1 / ln 2, and |r| <= 1/2; the second factor by its series to degree 7. */
#define EXP_SCALE 1.44269504f
#define EXP_UNDERFLOW (-126)

/* 1.5 * 2^23: a sum with it is rounded to an integer. */
#define EXP_ROUND 12582912

/* exp(x / EXP_SCALE) of two x in EXP_UNDERFLOW..0. */
static inline void exp_scaled_normal_pair(const real x[2], real result[2])
{
    for (int i = 0; i < 2; i++) {
        const real n = (x[i] + EXP_ROUND) - EXP_ROUND;
        const real r = (x[i] - n) * REAL(0.693147181);
        union {
            uint32_t bits;
            real value;
        } power = { ((uint32_t)(int32_t)n + 127) << 23 };
        real series = REAL(1.98412698e-4);

        series = series * r + REAL(1.38888889e-3);
        series = series * r + REAL(8.33333333e-3);
        series = series * r + REAL(4.16666667e-2);
        series = series * r + REAL(1.66666667e-1);
        series = series * r + REAL(0.5);
        series = series * r + 1;
        series = series * r + 1;
        result[i] = power.value * series;
    }
}
