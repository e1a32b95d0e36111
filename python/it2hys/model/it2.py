"""The IT2 core (10) and its inverse (30) as CasADi expressions: the model, written once.

Where `limits` are given, the displacements that the rules hold for, the core goes on beyond them as its
linearisation at the equilibrium of that end: F(y, x) = y_e + A (x - x_e) + s (y - y_e), with A = dF/dx
and s = dF/dy at (y_e, x_e), F(y_e, x_e) = y_e. Without, it is (10) everywhere.

Rules are L rows of (s1, s2, c, q1, q2, q3), the columns of Table 1. Units are the caller's. CasADi
derives every derivative; `it2hys.model.compiled` computes the same numbers in C where whole records are
run.
"""

from __future__ import annotations

from functools import cache

import casadi as ca

PARAMETERS_PER_RULE = 6


def _memberships(rules: ca.SX, y_previous: ca.SX) -> ca.SX:
    """Return f_l + F_l of all rules, (8), (9), (11), (12), up to a common factor.

    Everything is divided by the largest membership: (10) and (30) are ratios and do not change, and
    far from all centres, where every membership underflows, they tend to the nearest rule instead
    of 0/0.
    """
    squared = (y_previous - rules[:, 2]) ** 2
    lower = -squared / (2 * rules[:, 0] ** 2)
    upper = -squared / (2 * rules[:, 1] ** 2)
    largest = ca.mmax(ca.vertcat(lower, upper))
    return ca.exp(lower - largest) + ca.exp(upper - largest)


#: Numbers or expressions: lower and upper end of a range.
Limits = tuple[ca.SX, ca.SX] | tuple[float, float]


def step_expression(rules: ca.SX, y_previous: ca.SX, x: ca.SX, limits: Limits | None = None) -> ca.SX:
    """Return y(k) of (10).

    Parameters
    ----------
    rules : casadi.SX or casadi.MX, shape (L, 6)
        Columns s1, s2, c, q1, q2, q3.
    y_previous, x : casadi.SX or casadi.MX, scalar
        Displacement y(k-1) and voltage x(k).
    limits : tuple of two scalars, optional
        Range of y(k-1) that the rules hold for.

    Returns
    -------
    casadi.SX or casadi.MX, scalar
    """
    if limits is not None:
        within = _within(limits, y_previous)
        return step_expression(rules, within, x) + _go_on(rules, limits, y_previous, within)
    weight = _memberships(rules, y_previous)
    consequent = rules[:, 3] * y_previous + rules[:, 4] * x + rules[:, 5]
    return ca.dot(consequent, weight) / ca.sum1(weight)


def inverse_expression(
    rules: ca.SX, y_previous: ca.SX, y: ca.SX, limits: Limits | None = None
) -> ca.SX:
    """Return the voltage x(k) that takes y(k-1) to y(k), (30); arguments as `step_expression`."""
    if limits is not None:
        within = _within(limits, y_previous)
        return inverse_expression(rules, within, y - _go_on(rules, limits, y_previous, within))
    weight = _memberships(rules, y_previous)
    free = rules[:, 3] * y_previous + rules[:, 5]
    return (y * ca.sum1(weight) - ca.dot(free, weight)) / ca.dot(rules[:, 4], weight)


def _within(limits: Limits, y: ca.SX) -> ca.SX:
    """Return y, or the end that it lies beyond; with the derivative 1 at the ends themselves."""
    return ca.if_else(y < limits[0], limits[0], ca.if_else(y > limits[1], limits[1], y))


def _go_on(rules: ca.SX, limits: Limits, y: ca.SX, within: ca.SX) -> ca.SX:
    """Return s (y - y_e): what y(k) moves by, beyond what (10) makes of the end; 0 within the range."""
    slopes = [_slope_at_rest(rules, end) for end in limits]
    return ca.if_else(y < limits[0], slopes[0], slopes[1]) * (y - within)


def _slope_at_rest(rules: ca.SX, y: ca.SX) -> ca.SX:
    """Return dy(k)/dy(k-1) of (10) at the equilibrium at y."""
    symbols, y_previous, x = _symbols(rules.shape[0])
    slope = ca.gradient(step_expression(symbols, y_previous, x), y_previous)
    partial = ca.Function("it2_slope", [symbols, y_previous, x], [slope])
    return partial(rules, y, inverse_expression(rules, y, y))


def _symbols(rule_count: int) -> tuple[ca.SX, ca.SX, ca.SX]:
    rules = ca.SX.sym("rules", rule_count, PARAMETERS_PER_RULE)
    return rules, ca.SX.sym("y_previous"), ca.SX.sym("argument")


def _usability(rule_count: int) -> tuple[list[ca.SX], ca.SX]:
    """Return the symbols (rules, y, x_low, x_high) and the four values of `usability_function`."""
    rules, y_previous, x = _symbols(rule_count)
    x_low, x_high = ca.SX.sym("x_low"), ca.SX.sym("x_high")
    y = step_expression(rules, y_previous, x)
    partials = ca.Function(
        "it2_partials", [rules, y_previous, x], [ca.gradient(y, y_previous), ca.gradient(y, x)]
    )
    equilibrium = inverse_expression(rules, y_previous, y_previous)
    slopes = [partials(rules, y_previous, at) for at in (equilibrium, x_low, x_high)]
    values = ca.vertcat(*(by_y for by_y, _ in slopes), slopes[0][1])
    return [rules, y_previous, x_low, x_high], values


@cache
def usability_function(rule_count: int, points: int) -> ca.Function:
    """Return (rules, y, x_low, x_high) -> what must hold on a grid: contraction, invertibility.

    Parameters
    ----------
    rule_count, points : int
        Number of rules L and of grid points G.

    Returns
    -------
    casadi.Function
        From rules (L, 6) and y, x_low and x_high, each (1, G), to (4, G): dy(k)/dy(k-1) on the
        equilibrium curve, at x_low and at x_high, and dy(k)/dx(k), which is the denominator of
        (30) over the sum of memberships.
    """
    arguments, values = _usability(rule_count)
    point = ca.Function("it2_usability", arguments, [values])
    # all points share the rules
    return point.map("it2_usability_grid", "serial", points, [0], [])


@cache
def usability_jacobian(rule_count: int, points: int) -> ca.Function:
    """Return the derivatives of `usability_function` by the rules, (4, 6 L G).

    They come point by point, the rules column by column.
    """
    arguments, values = _usability(rule_count)
    jacobian = ca.densify(ca.jacobian(values, ca.vec(arguments[0])))
    point = ca.Function("it2_usability_jacobian", arguments, [jacobian])
    return point.map("it2_usability_jacobian_grid", "serial", points, [0], [])
