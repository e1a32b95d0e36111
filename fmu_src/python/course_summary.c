/* What sweeps make metrics of (python/it2hys/sweeps/measures.py): numbers of a course, or of how far it is from another.
 * numpy takes a pass for each of them; here all come from one pass. The sum of squares is numpy's to the last bit,
 * because its terms are added in the same order. Every loop over lanes becomes a few vector instructions. */
#include <math.h>
#include <stdint.h>

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* Numbers that are made side by side, and how many terms are added to them in a row: both are numpy's. */
enum { LANES = 8, BLOCK = 128 };

/* `zero` is the sum of all values times 0: 0 where all are finite, and only then the others are right. */
struct course_range {
    double low, high, zero;
};

/* Where `squares` is finite, the others are right. `low` and `high` are those of what the course is compared with. */
struct course_error {
    double largest, squares, low, high;
};

EXPORT void it2core_course_range(const double *course, int64_t count, struct course_range *range);
EXPORT void it2core_course_error(const double *course, const double *against, int64_t count,
                                 struct course_error *error);

/* Return how many values are not 0. */
EXPORT int64_t it2core_course_true(const double *course, int64_t count);

static inline double lower(double a, double b)
{
    return a < b ? a : b;
}

static inline double higher(double a, double b)
{
    return a > b ? a : b;
}

/* numpy's order. */
static double sum_of(const double lanes[LANES])
{
    return ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) + ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
}

static double lowest_of(const double lanes[LANES])
{
    double lowest = lanes[0];

    for (int i = 1; i < LANES; i++)
        lowest = lower(lowest, lanes[i]);
    return lowest;
}

static double highest_of(const double lanes[LANES])
{
    double highest = lanes[0];

    for (int i = 1; i < LANES; i++)
        highest = higher(highest, lanes[i]);
    return highest;
}

void it2core_course_range(const double *course, int64_t count, struct course_range *range)
{
    double low[LANES], high[LANES], zero[LANES] = { 0 };
    int64_t k = 0;

    for (int i = 0; i < LANES; i++) {
        low[i] = INFINITY;
        high[i] = -INFINITY;
    }
    for (; k + LANES <= count; k += LANES)
        for (int i = 0; i < LANES; i++) {
            const double value = course[k + i];
            low[i] = lower(low[i], value);
            high[i] = higher(high[i], value);
            zero[i] += 0.0 * value;
        }
    for (; k < count; k++) {
        low[0] = lower(low[0], course[k]);
        high[0] = higher(high[0], course[k]);
        zero[0] += 0.0 * course[k];
    }
    *range = (struct course_range){ lowest_of(low), highest_of(high), sum_of(zero) };
}

int64_t it2core_course_true(const double *course, int64_t count)
{
    double ones[LANES] = { 0 };
    int64_t k = 0;

    for (; k + LANES <= count; k += LANES)
        for (int i = 0; i < LANES; i++)
            ones[i] += course[k + i] != 0.0;
    for (; k < count; k++)
        ones[0] += course[k] != 0.0;
    return (int64_t)sum_of(ones);
}

/* What goes from block to block. */
struct lanes {
    double largest[LANES], low[LANES], high[LANES];
};

/* Return the sum of squares of a block. */
static double add_block(const double *course, const double *against, int64_t count, struct lanes *kept)
{
    struct lanes lanes = *kept;
    double squares[LANES] = { 0 };
    int64_t k = 0;

    for (; k + LANES <= count; k += LANES)
        for (int i = 0; i < LANES; i++) {
            const double error = against[k + i] - course[k + i];
            squares[i] += error * error;
            lanes.largest[i] = higher(lanes.largest[i], fabs(error));
            lanes.low[i] = lower(lanes.low[i], against[k + i]);
            lanes.high[i] = higher(lanes.high[i], against[k + i]);
        }
    double sum = sum_of(squares);
    for (; k < count; k++) {
        const double error = against[k] - course[k];
        sum += error * error;
        lanes.largest[0] = higher(lanes.largest[0], fabs(error));
        lanes.low[0] = lower(lanes.low[0], against[k]);
        lanes.high[0] = higher(lanes.high[0], against[k]);
    }
    *kept = lanes;
    return sum;
}

/* Return the sum of squares: those of two halves, until a half is a block. */
static double add_blocks(const double *course, const double *against, int64_t count, struct lanes *lanes)
{
    if (count <= BLOCK)
        return add_block(course, against, count, lanes);
    const int64_t half = count / 2 - count / 2 % LANES;
    const double first = add_blocks(course, against, half, lanes);
    return first + add_blocks(course + half, against + half, count - half, lanes);
}

void it2core_course_error(const double *course, const double *against, int64_t count,
                          struct course_error *error)
{
    struct lanes lanes = { .largest = { 0 } };

    for (int i = 0; i < LANES; i++) {
        lanes.low[i] = INFINITY;
        lanes.high[i] = -INFINITY;
    }
    const double squares = add_blocks(course, against, count, &lanes);
    *error = (struct course_error){ highest_of(lanes.largest), squares, lowest_of(lanes.low),
                                    highest_of(lanes.high) };
}
