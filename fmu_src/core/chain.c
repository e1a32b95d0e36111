#include "chain.h"

#include <math.h>
#include <stdio.h>

static struct it2_range displacement_range(const struct chain_parameters *parameters)
{
    return (struct it2_range){ parameters->displacementMin, parameters->displacementMax };
}

bool chain_check(const struct chain_parameters *parameters, char *message, size_t size)
{
    if (!(parameters->sampleTime > 0.0)) {
        snprintf(message, size, "sampleTime is %g s; it must be positive", parameters->sampleTime);
        return false;
    }
    if (!(parameters->voltageMin < parameters->voltageMax)) {
        snprintf(message, size, "voltageMin, %g V, must be below voltageMax, %g V",
                 parameters->voltageMin, parameters->voltageMax);
        return false;
    }
    return it2_check(parameters->rule, parameters->ruleCount, displacement_range(parameters), message,
                     size);
}

void chain_prepare(struct chain *chain, const struct chain_parameters *parameters)
{
    it2_prepare(&chain->core, parameters->rule, parameters->ruleCount);
    chain->displacement = displacement_range(parameters);
}

void chain_reset(struct chain_state *state, const struct chain_parameters *parameters)
{
    it2_reset(&state->core, parameters->initialDisplacement);
}

double chain_step(const struct chain *chain, struct chain_state *state, double voltage)
{
    return it2_step(&chain->core, &state->core, voltage);
}

static double within_reach(const struct chain *chain, double displacement)
{
    return fmin(fmax(displacement, chain->displacement.minimum), chain->displacement.maximum);
}

double chain_inverse(const struct chain *chain, struct chain_state *state, double displacement,
                     bool *saturated)
{
    const double aim = within_reach(chain, displacement);

    *saturated = aim != displacement;
    return it2_inverse(&chain->core, &state->core, aim);
}

struct chain_point chain_step_tangent(const struct chain *chain, const struct chain_state *state,
                                      double voltage, struct chain_state d_state, double d_voltage)
{
    const struct it2_partials f = it2_partials(&chain->core, state->core.y, voltage);
    const double dy = f.dy * d_state.core.y + f.dx * d_voltage;

    return (struct chain_point){ .state = { .core = { .y = dy } }, .output = dy };
}

/* From y = F(y_previous, x): dx = (dy - dF/dy_previous dy_previous) / (dF/dx). */
struct chain_point chain_inverse_tangent(const struct chain *chain, const struct chain_state *state,
                                         double displacement, struct chain_state d_state,
                                         double d_displacement)
{
    const double aim = within_reach(chain, displacement);
    const double d_aim = aim == displacement ? d_displacement : 0.0;
    const double x = it2_solve(&chain->core, state->core.y, aim);
    const struct it2_partials f = it2_partials(&chain->core, state->core.y, x);

    return (struct chain_point){ .state = { .core = { .y = d_aim } },
                                 .output = (d_aim - f.dy * d_state.core.y) / f.dx };
}

double chain_equilibrium(const struct chain *chain, const struct chain_state *state)
{
    return it2_solve(&chain->core, state->core.y, state->core.y);
}

/* From y = F(y, x, p): dx = (dy - dF/dy dy - dF/dp dp) / (dF/dx). */
double chain_equilibrium_tangent(const struct chain *chain, const struct chain_state *state,
                                 const struct chain_parameters *d_parameters)
{
    double gradient[IT2_RULE_PARAMETERS * IT2_MAX_RULES];
    struct it2_partials f;
    const double y = state->core.y;
    double d = d_parameters->initialDisplacement;

    it2_gradient(&chain->core, y, it2_solve(&chain->core, y, y), gradient, &f);
    d -= f.dy * d_parameters->initialDisplacement;
    for (int l = 0; l < chain->core.rules; l++) {
        const double *by_rule = gradient + IT2_RULE_PARAMETERS * l;
        const struct it2_rule *rule = &d_parameters->rule[l];
        d -= by_rule[0] * rule->sigmaLower + by_rule[1] * rule->sigmaUpper + by_rule[2] * rule->centre +
             by_rule[3] * rule->q1 + by_rule[4] * rule->q2 + by_rule[5] * rule->q3;
    }
    return d / f.dx;
}
