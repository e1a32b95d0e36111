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
#: Half width, at most, of the box around the start in which the evolutionary method searches.
_BOX = 1.0
#: It ends where so many generations lower the cost by less than this share.
_GENERATIONS, _GAIN = 100, 1e-3
#: Armijo's condition: share of the decrease promised by the gradient that a step must bring.
_SUFFICIENT = 1e-4
#: SciPy's status of SLSQP for a line search without descent.
_NO_DESCENT = 8
#: Stands for an infinite cost where a method subtracts costs.
_HUGE = 1e12
#: IPOPT's first barrier, and how far from its bounds it begins; all is scaled to about 1.
_BARRIER = 1e-6
_PUSHES = ("bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac")
#: IPOPT has arrived where it creeps on by less than so many tolerances, in so many iterations.
_CREEP, _SETTLED = 20.0, 10


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
    """SciPy's SLSQP, the counterpart of the paper's fminunc: BFGS with bounds.

    Along the principal axes, in which the first Hessian, the unit matrix, is Gauss-Newton's. Along the
    coordinates L-BFGS-B needs two to ten times the iterations, and more than the limit on some records.
    """
    axes, at = _axes(criterion, start)
    found = optimize.minimize(
        lambda place: min(cost(criterion, at(place)), _HUGE),
        np.zeros(len(start)),
        jac=lambda place: axes.T @ np.nan_to_num(gradient(criterion, at(place))),
        method="SLSQP",
        constraints=optimize.LinearConstraint(axes, criterion.lower - start, criterion.upper - start),
        options={"maxiter": max_iterations, "ftol": tolerance * min(cost(criterion, start), _HUGE)},
    )
    end = at(found.x)
    # a line search that finds nothing lower has arrived for all that rounding allows
    arrived = found.status in (0, _NO_DESCENT)
    message = "no further descent" if found.status == _NO_DESCENT else found.message
    return Minimum(end, cost(criterion, end), arrived, found.nit, found.nfev, message)


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
    """Differential evolution in a box around the start, the paper's future work.

    The box lies along the principal axes of the problem and is as long as the cost needs to double: one
    along the coordinates holds next to nothing that is better than the start.
    """
    _, at = _axes(criterion, start)
    sides = np.ones(len(start))
    costs: list[float] = []

    def has_settled(intermediate_result: optimize.OptimizeResult) -> bool:
        costs.append(intermediate_result.fun)
        return len(costs) > _GENERATIONS and costs[-1] > (1.0 - _GAIN) * costs[-1 - _GENERATIONS]

    found = optimize.differential_evolution(
        lambda place: min(cost(criterion, at(place)), _HUGE),
        optimize.Bounds(-sides, sides),
        x0=np.zeros(len(start)),
        maxiter=max_iterations,
        popsize=4,
        tol=tolerance,
        rng=seed,
        polish=False,
        callback=has_settled,
    )
    end, converged, message = at(found.x), bool(found.success), found.message
    if not converged and found.nit < max_iterations:
        converged = True
        message = f"the cost has fallen by less than {_GAIN:.1%} in {_GENERATIONS} generations"
    return Minimum(end, cost(criterion, end), converged, found.nit, found.nfev, message)


def _axes(
    criterion: ChainCriterion, start: np.ndarray
) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """Return steps along the principal axes, as columns, and the point that so many of them lead to.

    Over a step the cost about doubles, but it is no longer than `_BOX`.
    """
    linear, axes = criterion.full_jacobian(start), _BOX * np.eye(len(start))
    if linear is not None:
        jacobian, residual = linear
        _, slopes, rows = np.linalg.svd(jacobian, full_matrices=False)
        size = np.linalg.norm(residual)
        axes = rows.T * (size / np.maximum(slopes, size / _BOX))
    return axes, lambda steps: np.clip(start + axes @ steps, criterion.lower, criterion.upper)


def _ipopt(
    criterion: ChainCriterion, start: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> Minimum:
    """IPOPT on the problem as CasADi states it: contraction and invertibility as hard constraints.

    Its barrier begins low, or it would lead away from a start that is good: on a record of the stand to
    five times the cost. It ends, like the others, where the cost no longer falls: the multipliers of
    hundreds of constraints side by side may never settle.
    """
    stated = casadi_problem(criterion)
    inputs = stated.hessian.mx_in()
    triangle = ca.Function(
        "triangle",
        inputs,
        [ca.triu(stated.hessian(*inputs))],
        stated.hessian.name_in(),
        ["triu_hess_gamma_x_x"],
    )
    solver = ca.nlpsol(
        "identify",
        "ipopt",
        stated.problem,
        {
            "print_time": False,
            "show_eval_warnings": False,
            "hess_lag": triangle,
            "ipopt": {
                "print_level": 0,
                "sb": "yes",
                "max_iter": max_iterations,
                "tol": tolerance,
                "mu_init": _BARRIER,
                **dict.fromkeys(_PUSHES, _BARRIER),
                "acceptable_obj_change_tol": _CREEP * tolerance,
                "acceptable_iter": _SETTLED,
                "acceptable_tol": _HUGE,
                "acceptable_constr_viol_tol": tolerance,
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
