"""First-order lag of the amplifier, exact pole and no zero.

Its signature is a residual whose transfer from the voltage turns by less than 90 degrees and falls by
20 dB per decade above one corner, the same at every amplitude. Below the corner it is a delay.
"""

from collections.abc import Mapping

import numpy as np
from scipy.signal import lfilter

from it2hys.diagnosis.evidence.base import Signature
from it2hys.diagnosis.evidence.statistics import Answer, Stage, StepEvidence, readable
from it2hys.model.effects.lag import EFFECT
from it2hys.records.clues import Clues
from it2hys.support.numerals import plain


def _lagging(ticks: float) -> Stage:
    """Return a first-order lag of responses."""
    pole = np.exp(-1.0 / ticks)
    return lambda x: lfilter([1.0 - pole], [1.0, -pole], x)


class LagEvidence(StepEvidence):
    """A displacement that answers a step of the voltage at once, but flat at first."""

    meaning = "the amplifier follows the voltage as a low-pass filter does"
    experiment = (
        "a chirp or multisine up to the highest frequency of interest (behind a lag the amplitude "
        "falls by 20 dB per decade above one corner)"
    )

    imitated = True
    of_any_loop = True
    smooths = True
    answer = Answer(_lagging, tuple(np.geomspace(0.7, 60.0, 16)))

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return time constants from a tick to a tenth of the records."""
        start = EFFECT.starts(clues.extent)["lag.timeConstant"]
        shortest = 0.5 * clues.extent.sample_time
        return [{"lag.timeConstant": t} for t in np.geomspace(shortest, 0.5 * start.high, 10)]

    def is_within_a_sample(self, values: Mapping) -> bool:
        """Return whether the time constant is less than a sample."""
        return values["lag.timeConstant"] <= values["sampleTime"]

    def is_done_within(self, values: Mapping, time: float) -> bool:
        """Return whether two time constants are over."""
        return values["lag.timeConstant"] < 0.5 * time

    def signature(self, clues: Clues) -> Signature | None:
        """Return whether the displacement answers a step of the voltage at once, but flat at first.

        The response to steps is estimated for model and residual together and compared with those of
        cores behind a delay, a lag and a resonance; errors are spectral (HAC), the p-value an F test of
        what a lag explains beyond the others. The statistic is the share of the residual's power that
        it explains.
        """
        seen = readable(clues)
        if seen is None:
            return None
        found = self.dynamics(seen)
        constant = found.parameter * clues.extent.sample_time
        text = (
            "After a step of the voltage the displacement begins to move at once but slowly, as "
            f"behind a first-order lag of about {constant * 1e3:.2g} ms (corner "
            f"at {plain(0.159 / constant)} Hz): {100 * found.share:.0f} % of the residual's power."
        )
        return Signature(found.share, found.p_value, text)


EVIDENCE = LagEvidence()
