/* Checks that count, print where they fail and go on. */
#ifndef IT2HYS_CHECK_H
#define IT2HYS_CHECK_H

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

enum { CHECK_PRINTED = 20 }; /* failures beyond these are only counted */

/* Defined in each program by CHECK_MAIN. */
extern long check_count, check_failures;

#define CHECK_MAIN long check_count, check_failures

static inline bool check_that(bool ok, const char *text, const char *file, int line)
{
    check_count++;
    if (!ok && check_failures++ < CHECK_PRINTED)
        fprintf(stderr, "%s:%d: %s\n", file, line, text);
    return ok;
}

/* |value - expected| <= tolerance * |scale|; a NaN fails. */
static inline bool check_near(double value, double expected, double scale, double tolerance, const char *text,
                              const char *file, int line)
{
    const bool ok = fabs(value - expected) <= tolerance * fabs(scale);

    check_count++;
    if (!ok && check_failures++ < CHECK_PRINTED)
        fprintf(stderr, "%s:%d: %s: %.17g, expected %.17g within %g of %g\n", file, line, text, value, expected,
                tolerance, scale);
    return ok;
}

#define CHECK(condition) check_that((condition), #condition, __FILE__, __LINE__)
#define CHECK_NEAR(value, expected, scale, tolerance) \
    check_near((value), (expected), (scale), (tolerance), #value, __FILE__, __LINE__)
#define CHECK_CLOSE(value, expected, tolerance) CHECK_NEAR(value, expected, expected, tolerance)

/* The exit code of a test program. */
static inline int check_report(const char *topic)
{
    printf("%s: %ld checks, %ld failures\n", topic, check_count, check_failures);
    return check_failures > 0 || check_count == 0;
}

#endif
