"""Elastic load: compressive force shortens the actuator."""

from it2hys.model.effect import Effect, Scalar, Start, Surroundings, Values
from it2hys.records.clues import Extent


class Load(Effect):
    """Elastic load: the displacement falls in proportion to a compressive force."""

    def is_on(self, parameters: Values) -> bool:
        """Return whether the actuator gives way."""
        return parameters["load.compliance"] != 0.0

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the displacement under the force."""
        return x - values["load.compliance"] * around.force, []

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the displacement without the force."""
        return y + values["load.compliance"] * around.force, []

    def starts(self, extent: Extent) -> dict[str, Start]:
        """Start where the force moves a twentieth of the travel; nothing without a force channel."""
        if extent.force is None or extent.force[0] == extent.force[1]:
            return {}
        most = extent.displacement_span / (extent.force[1] - extent.force[0])
        return {"load.compliance": Start(0.05 * most, 0.0, 10.0 * most)}


EFFECT = Load()
