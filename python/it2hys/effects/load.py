"""Elastic load: compressive force shortens the actuator.

For it speaks a residual that follows the force channel linearly and without memory.
"""

import numpy as np

from it2hys.effects import Clues, Extent, Scalar, Signature, Start, Surroundings, Values
from it2hys.effects.statistics import UM, Ground, absorbed, readable

#: What the effect is, in plain words.
MEANING = "force on the stage shortens it"
#: What would show the effect apart from others.
EXPERIMENT = "a held voltage while the force changes, with the force recorded"


def is_on(parameters: Values) -> bool:
    """Return whether the actuator gives way."""
    return parameters["load.compliance"] != 0.0


def size(parameters: Values) -> int:
    """Return the number of states: none."""
    return 0


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input at rest without force."""
    return y, []


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the displacement under the force."""
    return x - values["load.compliance"] * around.force, []


def starts(extent: Extent) -> dict[str, Start]:
    """Start where the force's span moves a twentieth of the travel; nothing without a force channel."""
    if extent.force is None or extent.force[0] == extent.force[1]:
        return {}
    most = extent.displacement_span / (extent.force[1] - extent.force[0])
    return {"load.compliance": Start(0.05 * most, 0.0, 10.0 * most)}


def guesses(clues: Clues) -> list[dict[str, float]]:
    """Return the compliance by which the residual follows the force; nothing without a channel."""
    if not starts(clues.extent):
        return []
    force = np.concatenate([(c.force - c.force.mean())[c.used] for c in clues.records])
    residual = np.concatenate([(c.residual - c.residual.mean())[c.used] for c in clues.records])
    smallest = 1e-4 * starts(clues.extent)["load.compliance"].high
    return [{"load.compliance": max(-float(force @ residual / (force @ force)), smallest)}]


def signature(clues: Clues) -> Signature | None:
    """Return whether the residual falls with the force, by one coefficient; None without a force.

    The residual is regressed on the force, once the model's own means are taken out; errors are
    spectral and by blocks (HAC), the p-value is one-sided. The statistic is the share of the
    residual's power that the force explains.
    """
    seen = readable(clues)
    if seen is None or clues.extent.force is None or clues.extent.force[0] == clues.extent.force[1]:
        return None
    trial = Ground(seen, [absorbed(seen)]).test(lambda c: -c.force)
    yields = trial.coefficients[0] > 0.0
    p_value = 0.5 * trial.p_value if yields else 1.0 - 0.5 * trial.p_value
    text = (
        f"The residual falls with the force by {trial.coefficients[0] * UM:.3g} µm/N (standard error "
        f"{trial.errors[0] * UM:.2g}): {100 * trial.share:.0f} % of its power."
    )
    return Signature(trial.share if yields else 0.0, p_value, text)
