"""Delay of the voltage, straight between ticks.

Its signature is a residual that is the displacement's rate times one constant, at every frequency and
amplitude: a phase that falls linearly with frequency at a gain that stays. A lag also lowers the gain,
and the core itself is a lag; so the gain at the highest frequencies of the record has to decide.
"""

from collections.abc import Mapping, Sequence

from scipy.signal import lfilter

from it2hys.diagnosis.evidence.base import Signature
from it2hys.diagnosis.evidence.statistics import Answer, Stage, StepEvidence, readable
from it2hys.policy import PHYSICS
from it2hys.records.clues import Clues


def _delayed(ticks: float) -> Stage:
    """Return a delay of responses."""
    whole, part = int(ticks), ticks - int(ticks)
    return lambda x: lfilter([*[0.0] * whole, 1.0 - part, part], [1.0], x)


class DelayEvidence(StepEvidence):
    """A displacement that answers a step of the voltage late, but then at its full rate."""

    meaning = "the stage follows the voltage late by a constant time"
    experiment = (
        "a chirp or multisine up to the highest frequency of interest (a delay's phase falls in "
        "proportion to the frequency, its amplitude does not fall)"
    )

    imitated = True
    of_any_loop = True
    answer = Answer(_delayed, (0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 12.0, 20.0))

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return delays from a part of a tick to many."""
        ticks = (0.4, 0.9, 1.6, 2.5, 3.5, 5.5, 8.0, 12.0, 20.0, 40.0)
        return [{"delay.time": t * clues.extent.sample_time} for t in ticks]

    def promising(self, clues: Clues, trials: Sequence[Mapping]) -> list[int]:
        """Return the delays that are near the one that the response to steps shows, if any is."""
        every = list(range(len(trials)))
        seen = readable(clues)
        if seen is None:
            return every
        shown = self.dynamics(seen).parameter * clues.extent.sample_time
        near = [
            i
            for i, values in enumerate(trials)
            if 1.0 / PHYSICS.near_steps <= values["delay.time"] / shown <= PHYSICS.near_steps
        ]
        return near or every

    def is_within_a_sample(self, values: Mapping) -> bool:
        """Return whether the delay is less than a sample."""
        return values["delay.time"] <= values["sampleTime"]

    def signature(self, clues: Clues) -> Signature | None:
        """Return whether the displacement answers a step of the voltage late, then at its full rate.

        The response to steps is estimated for model and residual together and compared with those of
        cores behind a delay, a lag and a resonance; errors are spectral (HAC), the p-value an F test of
        what a delay explains beyond the others. The statistic is the share of the residual's power that
        it explains.
        """
        seen = readable(clues)
        if seen is None:
            return None
        found = self.dynamics(seen)
        text = (
            "After a step of the voltage the displacement stands still for about "
            f"{found.parameter * clues.extent.sample_time * 1e3:.3g} ms and then moves at its full "
            f"rate at once: {100 * found.share:.0f} % of the residual's power."
        )
        return Signature(found.share, found.p_value, text)


EVIDENCE = DelayEvidence()
