"""Elastic load: compressive force shortens the actuator.

Its signature is a residual that follows the force channel linearly and without memory.
"""

import numpy as np

from it2hys.diagnosis.evidence.base import EffectEvidence, Signature
from it2hys.diagnosis.evidence.statistics import UM, Ground, absorbed, readable
from it2hys.model.effects.load import EFFECT
from it2hys.records.clues import Clues


class LoadEvidence(EffectEvidence):
    """A residual that follows the force."""

    meaning = "force on the stage shortens it"
    experiment = "a held voltage while the force changes, with the force recorded"

    channel = "force"

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return the compliance by which the residual follows the force; nothing without a channel."""
        if not EFFECT.starts(clues.extent):
            return []
        force = np.concatenate([(c.force - c.force.mean())[c.used] for c in clues.records])
        residual = np.concatenate([(c.residual - c.residual.mean())[c.used] for c in clues.records])
        smallest = 1e-4 * EFFECT.starts(clues.extent)["load.compliance"].high
        return [{"load.compliance": max(-float(force @ residual / (force @ force)), smallest)}]

    def signature(self, clues: Clues) -> Signature | None:
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
            f"The residual falls with the force by {trial.coefficients[0] * UM:.3g} µm/N "
            "(standard error "
            f"{trial.errors[0] * UM:.2g}): {100 * trial.share:.0f} % of its power."
        )
        return Signature(trial.share if yields else 0.0, p_value, text)


EVIDENCE = LoadEvidence()
