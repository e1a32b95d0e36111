/* A clock and what makes timings comparable: two things are run in turn, in chunks of about 1 ms, A B A
 * B ..., and the median is taken over the ratios of neighbours: a machine that changes its clock slows
 * both alike. To be included once, before any other header. */
#ifndef IT2HYS_BENCH_H
#define IT2HYS_BENCH_H

#if !defined _WIN32
#define _POSIX_C_SOURCE 199309L
#endif
#include <stdlib.h>
#if defined _WIN32
#include <windows.h>
#else
#include <time.h>
#endif

#define ROUNDS 151
#define CHUNK_SECONDS 1e-3
#define CHUNK_MULTIPLE 100 /* repetitions come in multiples of this */

static inline double now(void)
{
#if defined _WIN32
    LARGE_INTEGER count, frequency;
    QueryPerformanceCounter(&count);
    QueryPerformanceFrequency(&frequency);
    return (double)count.QuadPart / (double)frequency.QuadPart;
#else
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
#endif
}

static inline int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static inline double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, ascending);
    return values[count / 2];
}

typedef void work(long repetitions);

static inline double seconds(work *f, long repetitions)
{
    const double start = now();
    f(repetitions);
    return now() - start;
}

static inline long repetitions_per_chunk(work *f)
{
    long n = CHUNK_MULTIPLE;

    while (seconds(f, n) < 0.25 * CHUNK_SECONDS)
        n *= 2;
    const long fitting = (long)((double)n * CHUNK_SECONDS / seconds(f, n));
    return (fitting / CHUNK_MULTIPLE + 1) * CHUNK_MULTIPLE;
}

/* Medians: nanoseconds per repetition of a and of b, and their ratio. */
struct comparison {
    double a, b, ratio;
};

static inline struct comparison compare(work *a, work *b)
{
    double ns_a[ROUNDS], ns_b[ROUNDS], ratio[ROUNDS];
    const long n_a = repetitions_per_chunk(a), n_b = repetitions_per_chunk(b);

    for (int i = 0; i < ROUNDS; i++) {
        ns_a[i] = 1e9 * seconds(a, n_a) / (double)n_a;
        ns_b[i] = 1e9 * seconds(b, n_b) / (double)n_b;
        ratio[i] = ns_a[i] / ns_b[i];
    }
    return (struct comparison){ median(ns_a, ROUNDS), median(ns_b, ROUNDS), median(ratio, ROUNDS) };
}

#endif
