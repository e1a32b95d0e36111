"""Drift with the temperature and with time.

Its signature is a residual that follows the temperature channel, or time, linearly and without memory,
whatever the voltage does; held voltages drift as moving ones do.
"""

from collections.abc import Mapping

import numpy as np

from it2hys.diagnosis.evidence.base import EffectEvidence, Signature
from it2hys.diagnosis.evidence.statistics import UM, Ground, absorbed, readable
from it2hys.model.effects.drift import EFFECT
from it2hys.records.clues import Clues


class DriftEvidence(EffectEvidence):
    """A residual that follows time or the temperature."""

    meaning = "the reading moves with temperature or time, whatever the voltage does"
    experiment = "a held voltage for as long as the records last, with the temperature recorded"

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return the slopes by which the residual follows time and temperature."""
        names, columns, target = list(EFFECT.starts(clues.extent)), [], []
        for i, c in enumerate(clues.records):
            time = np.arange(len(c.residual)) * clues.extent.sample_time
            rows = {"drift.rate": time, "drift.temperatureCoefficient": c.temperature}
            constants = np.zeros((len(time), len(clues.records)))
            constants[:, i] = 1.0
            columns.append(np.column_stack([*(rows[n] for n in names), constants])[c.used])
            target.append(c.residual[c.used])
        slopes = np.linalg.lstsq(np.vstack(columns), np.concatenate(target))[0]
        return [dict(zip(names, (float(v) for v in slopes), strict=False))]

    def signature(self, clues: Clues) -> Signature | None:
        """Return whether the residual follows temperature or time, by one coefficient in all records.

        The residual is regressed on each, once the model's own means are taken out; errors are spectral
        and by blocks (HAC) and enlarged where records disagree, the p-value is corrected for the choice
        between the two. The statistic is the share of the residual's power that the better one
        explains.
        """
        seen = readable(clues)
        if seen is None:
            return None
        ground, found = Ground(seen, [absorbed(seen)]), []
        time = ground.test(lambda c: np.arange(len(c.residual)) * clues.extent.sample_time)
        found.append((time, "time", "s"))
        if (
            clues.extent.temperature is not None
            and clues.extent.temperature[0] < clues.extent.temperature[1]
        ):
            found.append((ground.test(lambda c: c.temperature), "the temperature", "K"))
        trial, cause, unit = min(found, key=lambda f: (f[0].p_value, -f[0].share))
        text = (
            f"The residual follows {cause} by {trial.coefficients[0] * UM:.3g} µm/{unit} "
            "(standard error "
            f"{trial.errors[0] * UM:.2g}), whatever the voltage does: {100 * trial.share:.0f} % of "
            "its power."
        )
        return Signature(trial.share, min(1.0, len(found) * trial.p_value), text)

    def imitated_by(self, values: Mapping, rested: bool) -> str:
        """Return that slower creep does, where a drift with time is beside creep that is under way.

        The model describes what was before a record by two numbers. What they miss of creep that takes
        longer than a record goes one way in it, as a drift does.
        """
        if rested or not values["creepCount"] or values["drift.temperatureCoefficient"]:
            return ""
        return (
            "the stage still creeps when the records begin, and slow creep goes on in them nearly as a "
            "drift with time: begin them after a longer rest to tell the two apart"
        )


EVIDENCE = DriftEvidence()
