"""An identification as a CasADi problem: residuals of the compiled chain, constraints as expressions.

    minimise    1/2 r(x)^T r(x)                                              (23), with priors
    subject to  |dy(k)/dy(k-1)| of (10) below 1 over the band of the data    contraction
                dy(k)/dx(k) of (10), the denominator of (30), positive       invertibility
                the slope of the static curve at least `PHYSICS.curve_slope`  monotone curve
                lower <= x <= upper

r is a CasADi function that runs the compiled chain, with its exact Jacobian; the constraints are
expressions, which CasADi differentiates. Any solver of CasADi's `nlpsol` takes it.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from it2hys.identification.criterion import ChainCriterion
from it2hys.identification.usability import Band
from it2hys.model.it2 import usability_function
from it2hys.policy import CORE, PHYSICS

#: Least dy(k)/dx(k) of (10), scaled.
_SMALLEST_SLOPE = 1e-6


class Residuals(ca.Callback):
    """x -> r: the residuals of a criterion and its priors as a CasADi function.

    Where a run diverges they are NaN: solvers take a shorter step then.

    Parameters
    ----------
    criterion : ChainCriterion
    """

    def __init__(self, criterion: ChainCriterion):
        ca.Callback.__init__(self)
        self._criterion = criterion
        self._size = len(criterion.residual_or_nan(criterion.pack(criterion.model)))
        self._jacobian: ResidualsJacobian | None = None
        self.construct("residuals", {})

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        """Return the shape of the coordinates, (P, 1)."""
        return ca.Sparsity.dense(len(self._criterion.lower), 1)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        """Return the shape of the residuals, (M, 1)."""
        return ca.Sparsity.dense(self._size, 1)

    def eval(self, arguments: list[ca.DM]) -> list[ca.DM]:
        """Return the residuals."""
        return [ca.DM(self._criterion.residual_or_nan(np.asarray(arguments[0]).ravel()))]

    def has_jacobian(self) -> bool:
        """Say that the Jacobian is known."""
        return True

    def get_jacobian(
        self, name: str, inputs: list[str], outputs: list[str], options: dict
    ) -> ca.Function:
        """Return the Jacobian as a CasADi function; kept alive with this one."""
        self._jacobian = ResidualsJacobian(self._criterion, self._size, name, options)
        return self._jacobian


class ResidualsJacobian(ca.Callback):
    """(x, r) -> dr/dx, (M, P), by the sensitivities of the compiled chain."""

    def __init__(self, criterion: ChainCriterion, size: int, name: str, options: dict):
        ca.Callback.__init__(self)
        self._criterion, self._size = criterion, size
        self.construct(name, options)

    def get_n_in(self) -> int:
        """Return 2: the coordinates, and the residuals, which CasADi passes and are not needed."""
        return 2

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        """Return the shapes of the two inputs."""
        return ca.Sparsity.dense(len(self._criterion.lower) if i == 0 else self._size, 1)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        """Return the shape of the Jacobian."""
        return ca.Sparsity.dense(self._size, len(self._criterion.lower))

    def eval(self, arguments: list[ca.DM]) -> list[ca.DM]:
        """Return the Jacobian."""
        linear = self._criterion.full_jacobian(np.asarray(arguments[0]).ravel())
        shape = (self._size, len(self._criterion.lower))
        return [ca.DM(np.full(shape, np.nan) if linear is None else linear[0])]


@dataclass(frozen=True, eq=False)
class CasadiProblem:
    """A fit as CasADi's `nlpsol` takes it.

    Parameters
    ----------
    problem : dict
        x, f and g.
    lbx, ubx, lbg, ubg : ndarray
        Bounds of x, (P,), and of g.
    hessian : casadi.Function
        (x, p, lam_f, lam_g) -> that of the Lagrangian: lam_f J^T J, of Gauss and Newton, and the exact
        curvature of the constraints; as `hess_lag` IPOPT wants its upper triangle.
    residuals : Residuals
        Kept alive: CasADi does not own it.
    """

    problem: dict[str, ca.MX]
    lbx: np.ndarray
    ubx: np.ndarray
    lbg: np.ndarray
    ubg: np.ndarray
    hessian: ca.Function
    residuals: Residuals

    @property
    def bounds(self) -> dict[str, np.ndarray]:
        """The bounds by the names under which a solver takes them."""
        return {name: getattr(self, name) for name in ("lbx", "ubx", "lbg", "ubg")}


def casadi_problem(criterion: ChainCriterion) -> CasadiProblem:
    """State the fit of a chain as a CasADi problem.

    Parameters
    ----------
    criterion : ChainCriterion
        Its penalties, which stand for the constraints in a least-squares fit, are left out. The core is
        to contract and be invertible over their band; without one there is no such constraint.

    Returns
    -------
    CasadiProblem

    Examples
    --------
    >>> stated = casadi_problem(criterion)                                       # doctest: +SKIP
    >>> solver = ca.nlpsol("fit", "ipopt", stated.problem)                       # doctest: +SKIP
    >>> found = solver(x0=criterion.pack(criterion.model), **stated.bounds)      # doctest: +SKIP
    """
    free = criterion.unconstrained()
    residuals = Residuals(free)
    x = ca.MX.sym("x", len(free.lower))
    r = residuals(x)
    held = [
        *(_contraction_and_slope(x, criterion.rule_count, criterion.band) if criterion.band else ()),
        *_rising_curve(x, criterion),
    ]
    g = ca.vertcat(*(expression for expression, _, _ in held))
    lower, upper = (np.concatenate([[], *(h[i] for h in held)]) for i in (1, 2))
    factor, multipliers = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", g.numel())
    jacobian = ca.jacobian(r, x)
    hessian = ca.Function(
        "gauss_newton",
        [x, ca.MX.sym("p", 0), factor, multipliers],
        [factor * ca.mtimes(jacobian.T, jacobian) + ca.hessian(ca.dot(multipliers, g), x)[0]],
        ["x", "p", "lam_f", "lam_g"],
        ["hess_gamma_x_x"],
    )
    problem = {"x": x, "f": 0.5 * ca.sumsqr(r), "g": g}
    return CasadiProblem(problem, free.lower, free.upper, lower, upper, hessian, residuals)


_Held = tuple[ca.MX, np.ndarray, np.ndarray]


def _contraction_and_slope(x: ca.MX, rule_count: int, band: Band) -> list[_Held]:
    """Return dy(k)/dy(k-1) and dy(k)/dx(k) of (10) over a band as expressions with their bounds."""
    values = usability_function(rule_count, len(band.y))(_rules(x, rule_count), *band.rows)
    count = len(band.y)
    largest = np.full(3 * count, CORE.contraction)
    return [
        (ca.vec(values[:3, :].T), -largest, largest),
        (values[3, :].T, np.full(count, _SMALLEST_SLOPE), np.full(count, np.inf)),
    ]


def _rising_curve(x: ca.MX, criterion: ChainCriterion) -> list[_Held]:
    """Return the slopes of the static curve, where it is fitted, as expressions with their bounds."""
    rows = criterion.curve_slopes
    if not len(rows):
        return []
    least = np.full(len(rows), PHYSICS.curve_slope)
    return [(1.0 + ca.mtimes(ca.DM(rows), x), least, np.full(len(rows), np.inf))]


def _rules(x: ca.MX, rule_count: int) -> ca.MX:
    """Return the scaled rules, shape (L, 6), of the coordinates; see `rule_coordinates`."""
    table = ca.reshape(x[: 6 * rule_count], 6, rule_count).T
    lower = ca.exp(table[:, 0])
    return ca.horzcat(lower, lower * ca.exp(table[:, 1]), table[:, 2:])
