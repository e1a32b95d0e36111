/* sin of a phase that grows with the time, short enough to be inlined: for large ones, libm takes as long as half
 * of the other effects together.
 *
 * With the whole number n next to x / pi, sin x is sin(x - n pi), or the negative where n is odd. Three parts of
 * pi, the first two of 27 bits, so that n times them is exact; then r + r^3 p(r^2) with p of degree 7,
 * interpolated at Chebyshev nodes on |r| <= pi/2 (error 4e-19). Every compiler gets the same bits.
 * Measured error below 3e-16 (fmu_src/tests/test_sine.c). */
#ifndef IT2HYS_SINE_H
#define IT2HYS_SINE_H

#include <stdint.h>

#include "real.h"

#if defined IT2HYS_SINGLE

static inline real sine(real x)
{
    return real_sin(x);
}

#else

/* Beyond this, n would have more than 26 bits. */
#define SINE_LARGEST 2e8

static inline real sine(real x)
{
    union {
        real value;
        uint64_t bits;
    } rounded = { x * 0.3183098861837907 + 6755399441055744.0 }; /* 1.5 * 2^52: n stands in the low bits */
    const real n = rounded.value - 6755399441055744.0;
    const real r = ((x - n * 3.141592651605606) - n * 1.9841871479187034e-09) - n * 1.1442377452219664e-17;
    const real u = r * r, u2 = u * u;
    const real low = (-0.16666666666666666 + 0.008333333333333316 * u) +
                     (-0.00019841269841254966 + 2.7557319219160833e-06 * u) * u2;
    const real high = (-2.505210761669045e-08 + 1.6058977292642743e-10 * u) +
                      (-7.643969663988074e-13 + 2.7314368769379893e-15 * u) * u2;
    const real value = r + r * u * (low + high * (u2 * u2));

    if (!(real_fabs(x) <= SINE_LARGEST))
        return real_sin(x);
    return rounded.bits % 2 ? -value : value;
}

#endif

#endif
