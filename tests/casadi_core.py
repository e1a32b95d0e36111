"""The core's expressions as CasADi functions, to compare the C core with."""

from functools import cache

import casadi as ca

from it2hys.model import it2


def _symbols(rule_count: int) -> tuple[ca.SX, ca.SX, ca.SX]:
    rules = ca.SX.sym("rules", rule_count, it2.PARAMETERS_PER_RULE)
    return rules, ca.SX.sym("y_previous"), ca.SX.sym("argument")


@cache
def step_function(rule_count: int, limits: it2.Limits | None = None) -> ca.Function:
    """Return the function (rules, y_previous, x) -> y of (10) for L rules."""
    rules, y_previous, x = _symbols(rule_count)
    return ca.Function(
        "it2_step",
        [rules, y_previous, x],
        [it2.step_expression(rules, y_previous, x, limits)],
        ["rules", "y_previous", "x"],
        ["y"],
    )


@cache
def inverse_function(rule_count: int, limits: it2.Limits | None = None) -> ca.Function:
    """Return the function (rules, y_previous, y) -> x of (30) for L rules."""
    rules, y_previous, y = _symbols(rule_count)
    return ca.Function(
        "it2_inverse",
        [rules, y_previous, y],
        [it2.inverse_expression(rules, y_previous, y, limits)],
        ["rules", "y_previous", "y"],
        ["x"],
    )


@cache
def gradient_function(rule_count: int, limits: it2.Limits | None = None) -> ca.Function:
    """Return (rules, y_previous, x) -> derivatives of (10) by rules, (13) to (18), x and y(k-1).

    The first output has the shape of `rules`, the other two are scalars.
    """
    rules, y_previous, x = _symbols(rule_count)
    y = it2.step_expression(rules, y_previous, x, limits)
    return ca.Function(
        "it2_gradient",
        [rules, y_previous, x],
        [ca.gradient(y, rules), ca.gradient(y, x), ca.gradient(y, y_previous)],
        ["rules", "y_previous", "x"],
        ["by_rules", "by_x", "by_y_previous"],
    )


@cache
def free_run_function(rule_count: int, samples: int) -> ca.Function:
    """Return (y_initial, x, rules) -> y, the free run of (10) over N samples.

    The step is folded over the record (``mapaccum``), so the graph does not grow with N.

    Parameters
    ----------
    rule_count : int
        Number of rules L.
    samples : int
        Number of samples N.

    Returns
    -------
    casadi.Function
        From y_initial (scalar), x of shape (1, N) and rules of shape (L, 6) to y of shape (1, N).
    """
    rules, y_previous, x = _symbols(rule_count)
    step = ca.Function(
        "it2_tick", [y_previous, x, rules], [it2.step_expression(rules, y_previous, x)]
    ).mapaccum("it2_ticks", samples)
    y_initial, voltage = ca.MX.sym("y_initial"), ca.MX.sym("x", 1, samples)
    shared = ca.MX.sym("rules", rule_count, it2.PARAMETERS_PER_RULE)
    run = step(y_initial, voltage, ca.repmat(shared, 1, samples))
    return ca.Function(
        "it2_free_run", [y_initial, voltage, shared], [run], ["y_initial", "x", "rules"], ["y"]
    )
