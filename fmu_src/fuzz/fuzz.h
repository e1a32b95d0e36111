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

/* Promises that do not hold end the program: libFuzzer and the driver then name the bytes. */
#define FUZZ_PROMISE(condition) ((condition) ? (void)0 : fuzz_broken(#condition, __FILE__, __LINE__))

static inline void fuzz_broken(const char *promise, const char *file, int line)
{
    fprintf(stderr, "%s:%d: broken promise: %s\n", file, line, promise);
    abort();
}

#endif
