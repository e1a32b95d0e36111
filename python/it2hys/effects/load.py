"""Elastic load: compressive force shortens the actuator.

For it speaks a residual that follows the force channel linearly and without memory.
"""

import numpy as np

from it2hys.effects import Clues, Extent, Scalar, Start, Surroundings, Values

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
