"""The solvers of a fit by name, all on the same problem, `criterion.ChainCriterion`.

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

from it2hys.identification.casadi_problem import casadi_problem
from it2hys.identification.criterion import ChainCriterion, minimise_from
from it2hys.identification.levenberg_marquardt import Minimum
from it2hys.identification.result import Options

#: Relative change of the cost below which a fit has converged.
_TOLERANCE = 1e-6
#: Half width of the box, around the start, in which the evolutionary method searches.
_BOX = 1.0
#: Armijo's condition: share of the decrease promised by the gradient that a step must bring.
_SUFFICIENT = 1e-4
#: SciPy's status of L-BFGS-B for a limit of iterations or evaluations.
_LIMIT_REACHED = 1
#: Stands for an infinite cost where a method subtracts costs.
_HUGE = 1e12


def solve(
    criterion: ChainCriterion, start: np.ndarray, options: Options, tolerance: float = _TOLERANCE
) -> Minimum:
    """Minimise a criterion, (23), from one start by the solver that the options name.

    Parameters
    ----------
    criterion : ChainCriterion
    start : ndarray, shape (P,)
        Coordinates.
    options : Options
        `solver`, `max_iterations` (generations of the evolutionary method) and `seed`.
    tolerance : float
        Relative change of the cost that counts as none.

    Returns
    -------
    Minimum
    """
    start = np.clip(start, criterion.lower, criterion.upper)
    return _METHODS[options.solver](criterion, start, options.max_iterations, tolerance, options.seed)


def cost(criterion: ChainCriterion, point: np.ndarray) -> float:
    """Return the cost (23), infinite where the model diverges."""
    residual = criterion.residual(point)
    return np.inf if residual is None else 0.5 * float(residual @ residual)


def gradient(criterion: ChainCriterion, point: np.ndarray) -> np.ndarray:
    """Return the exact gradient of the cost (23), shape (P,), or NaN where the model diverges."""
    linear = criterion.linearise(point)
    return np.full(len(point), np.nan) if linear is None else linear.gradient


def _levenberg_marquardt(
    criterion: ChainCriterion, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> Minimum:
    return minimise_from(criterion, start, max_iterations, tolerance)


def _trust_region(
    criterion: ChainCriterion, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> Minimum:
    """SciPy's bounded Gauss-Newton trust region, the second opinion on the default."""
    # SciPy does not take NaN for a diverging step; a huge residual is rejected just as well.
    found = optimize.least_squares(
        lambda point: np.nan_to_num(criterion.residual_or_nan(point), nan=1e6),
        # it works strictly inside its bounds
        np.clip(start, criterion.lower + 1e-9, criterion.upper - 1e-9),
        lambda point: criterion.full_jacobian(point)[0],
        bounds=(criterion.lower, criterion.upper),
        ftol=tolerance,
        xtol=1e-12,
        gtol=1e-14,
        max_nfev=max_iterations,
    )
    return Minimum(found.x, found.cost, found.status > 0, found.njev, found.nfev, found.message)


def _quasi_newton(
    criterion: ChainCriterion, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> Minimum:
    """BFGS with bounds, the counterpart of the paper's fminunc.

    With more stored pairs than coordinates the limited-memory form holds the full matrix.
    """
    found = optimize.minimize(
        lambda point: min(cost(criterion, point), _HUGE),
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
    # a line search that finds nothing lower (status 2) has arrived for all that rounding allows
    stopped = found.status == _LIMIT_REACHED
    message = "no further descent" if found.status > _LIMIT_REACHED else found.message
    return Minimum(found.x, end, not stopped, found.nit, found.nfev, message)


def _gradient_descent(
    criterion: ChainCriterion, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
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
    criterion: ChainCriterion, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> Minimum:
    """Differential evolution in a box around the start, the paper's future work."""
    found = optimize.differential_evolution(
        lambda point: min(cost(criterion, point), _HUGE),
        optimize.Bounds(
            np.maximum(criterion.lower, start - _BOX), np.minimum(criterion.upper, start + _BOX)
        ),
        x0=start,
        maxiter=max_iterations,
        popsize=4,
        tol=tolerance,
        rng=seed,
        polish=False,
    )
    end = cost(criterion, found.x)
    return Minimum(found.x, end, bool(found.success), found.nit, found.nfev, found.message)


def _ipopt(
    criterion: ChainCriterion, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> Minimum:
    """IPOPT on the problem as CasADi states it: contraction and invertibility as hard constraints.

    Gauss-Newton's Hessian knows nothing of the constraints' curvature: on a record of the simulated
    stand it left 9 to 36 % more error after 300 iterations than a limited-memory one.
    """
    stated = casadi_problem(criterion)
    solver = ca.nlpsol(
        "identify",
        "ipopt",
        stated.problem,
        {
            "print_time": False,
            "show_eval_warnings": False,
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
    end = np.asarray(solver(x0=start, **stated.bounds)["x"]).ravel()
    stats = solver.stats()
    return Minimum(
        end,
        cost(criterion, end),
        bool(stats["success"]),
        int(stats["iter_count"]),
        int(stats["n_call_nlp_f"]),
        stats["return_status"],
    )


_Method = Callable[[ChainCriterion, np.ndarray, int, float, int], Minimum]

#: Solvers by the names in `result.SOLVERS`.
_METHODS: dict[str, _Method] = {
    "levenberg-marquardt": _levenberg_marquardt,
    "trust-region": _trust_region,
    "quasi-newton": _quasi_newton,
    "gradient-descent": _gradient_descent,
    "ipopt": _ipopt,
    "evolution": _evolution,
}
