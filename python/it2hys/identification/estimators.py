"""All estimators behind one interface, for either criterion.

The default, "levenberg-marquardt", is the best of them by measurement: on the free run of 1200
samples of the paper's protocol (6 nm noise) it reaches within 0.02 s the cost that SciPy's least
squares with finite differences return after 1.6 s and BFGS with exact gradients after 1.2 s, and
that gradient descent does not come near in 2 s (medians of `benchmarks/identification.py`).
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
from scipy import optimize

from it2hys.errors import InputError
from it2hys.identification import usability
from it2hys.identification.criteria import FreeRun
from it2hys.identification.levenberg_marquardt import Minimum, levenberg_marquardt
from it2hys.model.it2 import usability_function

#: Half width of the box, around the start, in which the evolutionary method searches.
_BOX = 1.0
#: Armijo's condition: share of the decrease promised by the gradient that a step must bring.
_SUFFICIENT = 1e-4


def minimise(
    criterion: FreeRun,
    start: np.ndarray,
    method: str = "levenberg-marquardt",
    *,
    max_iterations: int = 200,
    tolerance: float = 1e-9,
    seed: int = 0,
) -> Minimum:
    """Minimise a criterion, (23), from one start.

    Parameters
    ----------
    criterion : FreeRun or OneStep
    start : ndarray, shape (P,)
        Coordinates, see `FreeRun.pack`.
    method : str
        One of `METHODS`.
    max_iterations : int
        Limit of iterations; generations for the evolutionary method.
    tolerance : float
        Relative change of the cost that counts as none.
    seed : int
        Seed of the evolutionary method.

    Returns
    -------
    Minimum

    Raises
    ------
    InputError
        If the method is unknown.
    """
    if method not in METHODS:
        raise InputError(f"unknown estimator {method!r}; known are {', '.join(METHODS)}")
    start = np.clip(start, criterion.lower, criterion.upper)
    return METHODS[method](criterion, start, max_iterations, tolerance, seed)


def cost(criterion: FreeRun, point: np.ndarray) -> float:
    """Return the cost (23), infinite where the model diverges."""
    residual = criterion.residual(point)
    return np.inf if residual is None else 0.5 * float(residual @ residual)


def gradient(criterion: FreeRun, point: np.ndarray) -> np.ndarray:
    """Return the exact gradient of the cost (23), shape (P,), or NaN where the model diverges."""
    linear = criterion.linearise(point)
    return np.full(len(point), np.nan) if linear is None else linear.gradient


def _levenberg_marquardt(
    criterion: FreeRun, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> Minimum:
    return levenberg_marquardt(
        criterion.residual,
        criterion.linearise,
        start,
        criterion.lower,
        criterion.upper,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )


def _trust_region(
    criterion: FreeRun, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> Minimum:
    """SciPy's bounded Gauss-Newton trust region, the second opinion on the default."""
    # SciPy does not take None for a diverging step; a huge residual is rejected just as well.
    size = len(criterion.jacobian(start)[1])

    def residual(point: np.ndarray) -> np.ndarray:
        values = criterion.residual(point)
        return np.full(size, 1e6) if values is None else values

    def jacobian(point: np.ndarray) -> np.ndarray:
        return criterion.jacobian(point)[0]

    # The trust region works strictly inside its bounds.
    inside = np.clip(start, criterion.lower + 1e-9, criterion.upper - 1e-9)
    found = optimize.least_squares(
        residual,
        inside,
        jacobian,
        bounds=(criterion.lower, criterion.upper),
        ftol=tolerance,
        xtol=1e-12,
        gtol=1e-14,
        max_nfev=max_iterations,
    )
    return Minimum(found.x, found.cost, found.status > 0, found.njev, found.nfev, found.message)


def _quasi_newton(
    criterion: FreeRun, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> Minimum:
    """BFGS with bounds, the counterpart of the paper's fminunc.

    With more stored pairs than coordinates the limited-memory form holds the full matrix.
    """
    found = optimize.minimize(
        lambda point: _finite_cost(criterion, point),
        start,
        jac=lambda point: np.nan_to_num(gradient(criterion, point)),
        method="L-BFGS-B",
        bounds=optimize.Bounds(criterion.lower, criterion.upper),
        options={
            "maxcor": 2 * len(start),
            "maxiter": max_iterations,
            "maxfun": 4 * max_iterations,
            "ftol": 1e-3 * tolerance,
            "gtol": 1e-12,
        },
    )
    end = cost(criterion, found.x)
    return Minimum(found.x, end, found.success, found.nit, found.nfev, found.message)


def _gradient_descent(
    criterion: FreeRun, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> Minimum:
    """Step along the gradient of (23), (21), with the learning rate set by Armijo's condition."""
    point, value, rate, evaluations = start, cost(criterion, start), 1e-3, 1
    for iteration in range(1, max_iterations + 1):
        slope = gradient(criterion, point)
        rate *= 2.0
        while True:
            trial = np.clip(point - rate * slope, criterion.lower, criterion.upper)
            trial_value = cost(criterion, trial)
            evaluations += 1
            promised = slope @ (point - trial)
            if trial_value <= value - _SUFFICIENT * promised:
                break
            rate /= 2.0
            if rate < 1e-30:
                return Minimum(point, value, True, iteration, evaluations, "no further descent")
        gain, point, value = value - trial_value, trial, trial_value
        if gain <= tolerance * value:
            return Minimum(point, value, True, iteration, evaluations, "the cost no longer falls")
    message = "the limit of iterations is reached"
    return Minimum(point, value, False, max_iterations, evaluations, message)


def _evolution(
    criterion: FreeRun, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> Minimum:
    """Differential evolution in a box around the start, the paper's future work."""
    lower = np.maximum(criterion.lower, start - _BOX)
    upper = np.minimum(criterion.upper, start + _BOX)
    found = optimize.differential_evolution(
        lambda point: _finite_cost(criterion, point),
        optimize.Bounds(lower, upper),
        x0=start,
        maxiter=max_iterations,
        popsize=4,
        tol=tolerance,
        rng=seed,
        polish=False,
    )
    return Minimum(
        found.x, cost(criterion, found.x), bool(found.success), found.nit, found.nfev, found.message
    )


def _finite_cost(criterion: FreeRun, point: np.ndarray) -> float:
    """Return the cost, or a large number where it is infinite, for methods that subtract costs."""
    return min(cost(criterion, point), 1e12)


class CostCallback(ca.Callback):
    """The cost of a criterion as a CasADi function: the C core behind CasADi's interface.

    Parameters
    ----------
    criterion : FreeRun
    """

    def __init__(self, criterion: FreeRun):
        ca.Callback.__init__(self)
        self._criterion = criterion
        self._gradient: CostGradient | None = None
        self.construct("it2_cost", {})

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        """Return the shape of the coordinates."""
        return ca.Sparsity.dense(len(self._criterion.lower), 1)

    def eval(self, arguments: list[ca.DM]) -> list[float]:
        """Return the cost."""
        return [_finite_cost(self._criterion, np.asarray(arguments[0]).ravel())]

    def has_jacobian(self) -> bool:
        """Say that the gradient is known."""
        return True

    def get_jacobian(
        self, name: str, inputs: list[str], outputs: list[str], options: dict
    ) -> ca.Function:
        """Return the gradient as a CasADi function; kept alive with this one."""
        self._gradient = CostGradient(self._criterion, name, options)
        return self._gradient


class CostGradient(ca.Callback):
    """The gradient of a criterion's cost as a CasADi function."""

    def __init__(self, criterion: FreeRun, name: str, options: dict):
        ca.Callback.__init__(self)
        self._criterion = criterion
        self.construct(name, options)

    def get_n_in(self) -> int:
        """Return 2: the coordinates, and the cost, which CasADi passes and is not needed."""
        return 2

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        """Return the shapes of the two inputs."""
        return ca.Sparsity.dense(len(self._criterion.lower), 1) if i == 0 else ca.Sparsity(1, 1)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        """Return the shape of the gradient, a row."""
        return ca.Sparsity.dense(1, len(self._criterion.lower))

    def eval(self, arguments: list[ca.DM]) -> list[ca.DM]:
        """Return the gradient."""
        values = gradient(self._criterion, np.asarray(arguments[0]).ravel())
        return [ca.DM(values).T]


def _ipopt(
    criterion: FreeRun, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> Minimum:
    """IPOPT with contraction and invertibility as hard constraints over the band of the data."""
    point = ca.MX.sym("point", len(start))
    callback = CostCallback(criterion)
    band = usability.Band.of_data(criterion.series, criterion.offsets(start))
    rules = _rules_expression(point, criterion.rule_count)
    held = ca.vec(usability_function(criterion.rule_count, len(band.y))(rules, *band.rows).T)
    solver = ca.nlpsol(
        "identify",
        "ipopt",
        {"x": point, "f": callback(point), "g": held},
        {
            "print_time": False,
            "ipopt": {
                "print_level": 0,
                "sb": "yes",
                "hessian_approximation": "limited-memory",
                "limited_memory_max_history": 2 * len(start),
                "max_iter": max_iterations,
                "tol": tolerance,
            },
        },
    )
    largest = usability.LARGEST_CONTRACTION
    found = solver(
        x0=start,
        lbx=criterion.lower,
        ubx=criterion.upper,
        lbg=np.repeat([-largest, -largest, -largest, 1e-6], len(band.y)),
        ubg=np.repeat([largest, largest, largest, np.inf], len(band.y)),
    )
    stats, end = solver.stats(), np.asarray(found["x"]).ravel()
    return Minimum(
        end,
        cost(criterion, end),
        bool(stats["success"]),
        int(stats["iter_count"]),
        int(stats["n_call_nlp_f"]),
        stats["return_status"],
    )


def _rules_expression(point: ca.MX, rule_count: int) -> ca.MX:
    """Return the rules, shape (L, 6), of the coordinates as an expression; see `coordinates`."""
    table = ca.reshape(point[: 6 * rule_count], 6, rule_count).T
    lower = ca.exp(table[:, 0])
    return ca.horzcat(lower, lower * ca.exp(table[:, 1]), table[:, 2:])


_Method = Callable[[FreeRun, np.ndarray, int, float, int], Minimum]

#: Estimators by name.
METHODS: dict[str, _Method] = {
    "levenberg-marquardt": _levenberg_marquardt,
    "trust-region": _trust_region,
    "quasi-newton": _quasi_newton,
    "gradient-descent": _gradient_descent,
    "ipopt": _ipopt,
    "evolution": _evolution,
}
