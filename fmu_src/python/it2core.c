/* The core as a shared library for Python (python/it2hys/model/compiled.py): plain arrays in and out.
 * `rules` is an array of 6 numbers per rule, in the order of struct it2_rule; `range` is two, infinite for (10)
 * everywhere. `parameters` is a struct
 * chain_parameters that Python fills by the places that it2core_chain_parameter names. */
#include <math.h>
#include <stdint.h>

#include "../core/chain.h"
#include "../core/it2_membership.h"
#include "../identification/chain_sensitivity.h"
#include "chain_table.h"

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

EXPORT size_t it2core_free_run(const struct it2_rule *rules, int count, const double *range, const double *x,
                               size_t n, double y_initial, double *y);
EXPORT void it2core_one_step(const struct it2_rule *rules, int count, const double *range,
                             const double *y_previous, const double *x, size_t n, double *y);
EXPORT void it2core_solve(const struct it2_rule *rules, int count, const double *range,
                          const double *y_previous, const double *y, size_t n, double *x);
EXPORT double it2core_gradient(const struct it2_rule *rules, int count, const double *range, double y_previous,
                               double x, double *by_rules, double *by_arguments);
EXPORT double it2core_contraction(const struct it2_rule *rules, int count, double minimum, double maximum);
EXPORT void it2core_usability(const struct it2_rule *rules, int count, const double *y, const double *x_low,
                              const double *x_high, size_t n, double *values);
EXPORT bool it2core_check(const struct it2_rule *rules, int count, double minimum, double maximum,
                          char *message, size_t size);

EXPORT size_t it2core_chain_size(void);
EXPORT size_t it2core_chain_parameter(int index, const char **name, int *integer);
EXPORT bool it2core_chain_check(const void *parameters, char *message, size_t size);
EXPORT size_t it2core_chain_run(const void *parameters, const double *voltage, const double *force,
                                const double *temperature, int64_t first_tick, size_t n, double *displacement,
                                double *measured, int *outside);
EXPORT size_t it2core_chain_inverse(const void *parameters, const double *reference, const double *force,
                                    const double *temperature, int64_t first_tick, size_t n, double *voltage,
                                    int *limits);
EXPORT double it2core_chain_equilibrium(const void *parameters);
EXPORT size_t it2core_chain_predict(const void *parameters, const struct chain_record *record, double *measured,
                                    double *core_input, double *core_output);
EXPORT bool it2core_chain_predict_each(const double *parameters, size_t stride,
                                       const struct chain_record *records, size_t count, double *measured);
EXPORT size_t it2core_chain_sensitivity(const void *parameters, const struct chain_record *record,
                                        bool by_rules, const size_t *places, int count, double *measured,
                                        double *sensitivity);

static struct it2_range range_of(const double *range)
{
    return (struct it2_range){ range[0], range[1] };
}

size_t it2core_free_run(const struct it2_rule *rules, int count, const double *range, const double *x, size_t n,
                        double y_initial, double *y)
{
    return it2_free_run(rules, count, range_of(range), x, n, y_initial, y, NULL);
}

void it2core_one_step(const struct it2_rule *rules, int count, const double *range, const double *y_previous,
                      const double *x, size_t n, double *y)
{
    struct it2 stage;

    it2_prepare(&stage, rules, count, range_of(range));
    for (size_t k = 0; k < n; k++)
        y[k] = it2_evaluate(&stage, y_previous[k], x[k]);
}

void it2core_solve(const struct it2_rule *rules, int count, const double *range, const double *y_previous,
                   const double *y, size_t n, double *x)
{
    struct it2 stage;

    it2_prepare(&stage, rules, count, range_of(range));
    for (size_t k = 0; k < n; k++)
        x[k] = it2_solve(&stage, y_previous[k], y[k]);
}

double it2core_gradient(const struct it2_rule *rules, int count, const double *range, double y_previous,
                        double x, double *by_rules, double *by_arguments)
{
    struct it2 stage;
    struct it2_partials partials;

    it2_prepare(&stage, rules, count, range_of(range));
    const double y = it2_gradient(&stage, y_previous, x, by_rules, &partials);
    by_arguments[0] = partials.dx;
    by_arguments[1] = partials.dy;
    by_arguments[2] = partials.end;
    return y;
}

double it2core_contraction(const struct it2_rule *rules, int count, double minimum, double maximum)
{
    struct it2 stage;
    double where;

    it2_prepare(&stage, rules, count, IT2_EVERYWHERE);
    return it2_contraction(&stage, (struct it2_range){ minimum, maximum }, &where);
}

/* dy_k/dy_{k-1} of (10) at n displacements, at the equilibrium and at two voltages, and dy_k/dx_k: four rows of n.
 * With w = (f + F) / D and v = dw/dy of fixed D, dy_k/dy_{k-1} = sum w q1 + sum v (n - y_k): affine in x_k, so
 * that all four come from one set of memberships. A fit asks for them at every step; it2_partials takes three. */
void it2core_usability(const struct it2_rule *rules, int count, const double *y, const double *x_low,
                       const double *x_high, size_t n, double *values)
{
    struct it2 stage;
    struct it2_memberships m;

    it2_prepare(&stage, rules, count, IT2_EVERYWHERE);
    for (size_t k = 0; k < n; k++) {
        double at_rest = 0, slope = 0, constant = 0, by_x = 0, moved = 0;
        it2_memberships(&stage, y[k], &m);
        for (int l = 0; l < count; l++) {
            const struct it2_rule *r = &rules[l];
            const double weight = m.weight[l] / m.sum;
            const double change =
                (m.lower[l] / (r->sigmaLower * r->sigmaLower) + m.upper[l] / (r->sigmaUpper * r->sigmaUpper)) *
                (r->centre - y[k]) / m.sum;
            const double unforced = r->q1 * y[k] + r->q3;
            at_rest += weight * unforced;
            slope += weight * r->q2;
            constant += weight * r->q1 + change * unforced;
            by_x += change * r->q2;
            moved += change;
        }
        constant -= at_rest * moved;
        by_x -= slope * moved;
        /* a slope of 0 has no equilibrium; the penalty on the slope speaks for that point */
        const double equilibrium = slope == 0 ? 0 : (y[k] - at_rest) / slope;
        values[k] = constant + by_x * equilibrium;
        values[n + k] = constant + by_x * x_low[k];
        values[2 * n + k] = constant + by_x * x_high[k];
        values[3 * n + k] = slope;
    }
}

bool it2core_check(const struct it2_rule *rules, int count, double minimum, double maximum, char *message,
                   size_t size)
{
    return it2_check(rules, count, (struct it2_range){ minimum, maximum }, message, size);
}

size_t it2core_chain_size(void)
{
    return sizeof(struct chain_parameters);
}

/* Offset, name and kind of a parameter by its number; no name (NULL) beyond the last. */
size_t it2core_chain_parameter(int index, const char **name, int *integer)
{
    const bool exists = index >= 0 && index < (int)(sizeof CHAIN_TABLE / sizeof CHAIN_TABLE[0]);

    *name = exists ? CHAIN_TABLE[index].name : NULL;
    *integer = exists && CHAIN_TABLE[index].integer;
    return exists ? CHAIN_TABLE[index].offset : 0;
}

bool it2core_chain_check(const void *parameters, char *message, size_t size)
{
    return chain_check(parameters, message, size);
}

static struct chain_surroundings surroundings(const struct chain_parameters *parameters, const double *force,
                                              const double *temperature, int64_t first_tick, size_t k)
{
    const double time = (double)(first_tick + (int64_t)k) * parameters->sampleTime;

    return (struct chain_surroundings){ force[k], temperature[k], time };
}

/* A chain at rest, made as FMUs make it: the same bits come out. */
struct runner {
    struct chain chain;
    struct chain_state state;
    struct it2_table table;
};

static void begin(struct runner *runner, const struct chain_parameters *parameters)
{
    chain_prepare(&runner->chain, parameters);
    chain_reset(&runner->chain, &runner->state, parameters);
    runner->table.rules = 0;
    it2_tabulate(&runner->chain.core, &runner->table);
}

/* Return the number of samples computed: less than n if a value is not finite. `outside` is outOfRange of
 * the plant FMU. */
size_t it2core_chain_run(const void *parameters, const double *voltage, const double *force,
                         const double *temperature, int64_t first_tick, size_t n, double *displacement,
                         double *measured, int *outside)
{
    const struct chain_parameters *p = parameters;
    struct runner r;

    begin(&r, parameters);
    for (size_t k = 0; k < n; k++) {
        const struct chain_surroundings around = surroundings(parameters, force, temperature, first_tick, k);
        displacement[k] = chain_step(&r.chain, &r.state, voltage[k], &around);
        measured[k] = chain_measure(&r.chain, displacement[k], around.time);
        outside[k] = chain_outside(voltage[k], p->voltageMin, p->voltageMax) ||
                     chain_outside(r.state.core.y, p->displacementMin, p->displacementMax);
        if (!isfinite(measured[k]))
            return k;
    }
    return n;
}

size_t it2core_chain_inverse(const void *parameters, const double *reference, const double *force,
                             const double *temperature, int64_t first_tick, size_t n, double *voltage,
                             int *limits)
{
    struct runner r;
    unsigned limit;

    begin(&r, parameters);
    for (size_t k = 0; k < n; k++) {
        const struct chain_surroundings around = surroundings(parameters, force, temperature, first_tick, k);
        voltage[k] = chain_inverse(&r.chain, &r.state, reference[k], &around, &limit);
        limits[k] = (int)limit;
        if (!isfinite(voltage[k]))
            return k;
    }
    return n;
}

/* The voltage that holds the plant where it begins. */
double it2core_chain_equilibrium(const void *parameters)
{
    struct chain chain;
    struct chain_state state;

    chain_prepare(&chain, parameters);
    chain_reset(&chain, &state, parameters);
    return chain_equilibrium(&chain, &state);
}

size_t it2core_chain_predict(const void *parameters, const struct chain_record *record, double *measured,
                             double *core_input, double *core_output)
{
    return chain_predict(parameters, record, measured, core_input, core_output);
}

/* The readings of records, one after the other, from parameters that are `stride` numbers apart. Returns whether
 * all are finite; nothing is computed after one that is not. */
bool it2core_chain_predict_each(const double *parameters, size_t stride, const struct chain_record *records,
                                size_t count, double *measured)
{
    for (size_t i = 0; i < count; i++) {
        const void *own = parameters + i * stride;
        if (chain_predict(own, &records[i], measured, NULL, NULL) < records[i].samples)
            return false;
        measured += records[i].samples;
    }
    return true;
}

size_t it2core_chain_sensitivity(const void *parameters, const struct chain_record *record, bool by_rules,
                                 const size_t *places, int count, double *measured, double *sensitivity)
{
    return chain_sensitivity(parameters, record, by_rules, places, count, measured, sensitivity);
}
