/* The core over a whole record from voltage alone, with forward sensitivities:
 * S_k = dF/dp + dF/dy_{k-1} S_{k-1}, the derivatives of y_k with respect to the parameters p. */
#include <string.h>

#include "it2_table.h"

static size_t simulate(const struct it2 *stage, const real *x, size_t n, real y_initial, real *y)
{
    real previous = y_initial;

    for (size_t k = 0; k < n; k++) {
        y[k] = previous = it2_evaluate(stage, previous, x[k]);
        if (!isfinite(previous))
            return k;
    }
    return n;
}

size_t it2_free_run(const struct it2_rule *rules, int count, struct it2_range range, const real *x, size_t n,
                    real y_initial, real *y, real *sensitivity)
{
    struct it2 stage;
    struct it2_partials partials;
    const int parameters = IT2_RULE_PARAMETERS * count;
    const size_t columns = (size_t)parameters + 1;
    real row[IT2_RULE_PARAMETERS * IT2_MAX_RULES + 1] = { 0 };
    real gradient[IT2_RULE_PARAMETERS * IT2_MAX_RULES];
    real previous = y_initial;

    it2_prepare(&stage, rules, count, range);
    if (!sensitivity)
        return simulate(&stage, x, n, y_initial, y);
    row[parameters] = 1; /* d y_initial / d y_initial */
    for (size_t k = 0; k < n; k++) {
        y[k] = previous = it2_gradient(&stage, previous, x[k], gradient, &partials);
        if (!isfinite(previous) || !isfinite(partials.dy))
            return k;
        for (int i = 0; i < parameters; i++)
            row[i] = gradient[i] + partials.dy * row[i];
        row[parameters] *= partials.dy;
        memcpy(sensitivity + k * columns, row, columns * sizeof(real));
    }
    return n;
}
