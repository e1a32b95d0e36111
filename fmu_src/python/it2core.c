/* The core as a shared library for Python (python/it2hys/core.py): plain arrays in and out.
 * `rules` is an array of 6 numbers per rule, in the order of struct it2_rule. */
#include "../core/it2.h"

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

EXPORT size_t it2core_free_run(const struct it2_rule *rules, int count, const double *x, size_t n,
                               double y_initial, double *y, double *sensitivity);
EXPORT void it2core_one_step(const struct it2_rule *rules, int count, const double *y_previous,
                             const double *x, size_t n, double *y);
EXPORT void it2core_solve(const struct it2_rule *rules, int count, const double *y_previous,
                          const double *y, size_t n, double *x);
EXPORT double it2core_gradient(const struct it2_rule *rules, int count, double y_previous, double x,
                               double *by_rules, double *by_arguments);
EXPORT double it2core_contraction(const struct it2_rule *rules, int count, double minimum,
                                  double maximum);
EXPORT bool it2core_check(const struct it2_rule *rules, int count, double minimum, double maximum,
                          char *message, size_t size);

size_t it2core_free_run(const struct it2_rule *rules, int count, const double *x, size_t n,
                        double y_initial, double *y, double *sensitivity)
{
    return it2_free_run(rules, count, x, n, y_initial, y, sensitivity);
}

void it2core_one_step(const struct it2_rule *rules, int count, const double *y_previous,
                      const double *x, size_t n, double *y)
{
    struct it2 stage;

    it2_prepare(&stage, rules, count);
    for (size_t k = 0; k < n; k++)
        y[k] = it2_evaluate(&stage, y_previous[k], x[k]);
}

void it2core_solve(const struct it2_rule *rules, int count, const double *y_previous, const double *y,
                   size_t n, double *x)
{
    struct it2 stage;

    it2_prepare(&stage, rules, count);
    for (size_t k = 0; k < n; k++)
        x[k] = it2_solve(&stage, y_previous[k], y[k]);
}

double it2core_gradient(const struct it2_rule *rules, int count, double y_previous, double x,
                        double *by_rules, double *by_arguments)
{
    struct it2 stage;
    struct it2_partials partials;

    it2_prepare(&stage, rules, count);
    const double y = it2_gradient(&stage, y_previous, x, by_rules, &partials);
    by_arguments[0] = partials.dx;
    by_arguments[1] = partials.dy;
    return y;
}

double it2core_contraction(const struct it2_rule *rules, int count, double minimum, double maximum)
{
    struct it2 stage;
    double where;

    it2_prepare(&stage, rules, count);
    return it2_contraction(&stage, (struct it2_range){ minimum, maximum }, &where);
}

bool it2core_check(const struct it2_rule *rules, int count, double minimum, double maximum,
                   char *message, size_t size)
{
    return it2_check(rules, count, (struct it2_range){ minimum, maximum }, message, size);
}
