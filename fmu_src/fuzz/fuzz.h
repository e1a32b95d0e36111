/* Fuzzing. A target is a function of a byte string, LLVMFuzzerTestOneInput: libFuzzer calls it where
 * clang is the compiler, fuzz_driver.c everywhere else.
 *
 *   fuzz_calls.c        FMI calls with any arguments, in any order, on several instances; FMU states
 *   fuzz_fmi3.c         the same under FMI 3.0, with arrays that are resized and hosts within steps
 *   fuzz_parameters.c   parameter files
 *   fuzz_controller.c   FMI calls on PIController
 *
 * A broken promise ends the program with the byte string in hex, which `fuzz_<target> -x HEX` runs
 * again. corpus/<target>.hex holds strings worth starting from, one per line. */
#ifndef IT2HYS_FUZZ_H
#define IT2HYS_FUZZ_H

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Bytes are taken from the front; beyond the end they are 0. */
struct fuzz_bytes {
    const uint8_t *next;
    const uint8_t *end;
};

static inline unsigned fuzz_byte(struct fuzz_bytes *bytes)
{
    return bytes->next < bytes->end ? *bytes->next++ : 0u;
}

static inline void fuzz_take(struct fuzz_bytes *bytes, void *target, size_t size)
{
    uint8_t *byte = target;

    for (size_t i = 0; i < size; i++)
        byte[i] = (uint8_t)fuzz_byte(bytes);
}

static inline unsigned fuzz_short(struct fuzz_bytes *bytes)
{
    const unsigned high = fuzz_byte(bytes);
    return high << 8 | fuzz_byte(bytes);
}

/* Voltages and lengths as they are used, what is special, and any bits. */
static inline double fuzz_number(struct fuzz_bytes *bytes)
{
    static const double SPECIAL[] = { 0.0,     -0.0,   NAN,  INFINITY, -INFINITY, DBL_MAX, -DBL_MAX,
                                      DBL_MIN, 5e-324, 1e16, 1e-12,    1.0,       -1.0,    1e150 };
    const unsigned kind = fuzz_byte(bytes);
    double value;

    if (kind < sizeof SPECIAL / sizeof *SPECIAL)
        return SPECIAL[kind];
    if (kind < 120)
        return fuzz_byte(bytes) * 0.6; /* V */
    if (kind < 240)
        return fuzz_byte(bytes) * 7e-8; /* m */
    fuzz_take(bytes, &value, sizeof value);
    return value;
}

/* One of the first few variables, which are inputs and outputs, one of all and one beyond, or any number. */
static inline uint32_t fuzz_reference(struct fuzz_bytes *bytes, unsigned few, unsigned all)
{
    const unsigned kind = fuzz_byte(bytes);
    uint32_t any;

    if (kind < 128)
        return kind % few;
    if (kind < 250)
        return fuzz_short(bytes) % (all + 1u);
    fuzz_take(bytes, &any, sizeof any);
    return any;
}

/* Promises that do not hold end the program: libFuzzer and the driver then name the bytes. */
#define FUZZ_PROMISE(condition) ((condition) ? (void)0 : fuzz_broken(#condition, __FILE__, __LINE__))

static inline void fuzz_broken(const char *promise, const char *file, int line)
{
    fprintf(stderr, "%s:%d: broken promise: %s\n", file, line, promise);
    abort();
}

#endif
