"""A line on the reading that is not in the voltage.

Its signature is one narrow line in the residual's spectrum, of the same frequency and amplitude in
every record, where the voltage has none: incoherent with it, there in rest as in motion.
"""

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import find_peaks

from it2hys.diagnosis.evidence.base import EffectEvidence, Signature
from it2hys.diagnosis.evidence.statistics import UM, line_ratios, readable
from it2hys.model.effects.hum import lines_in
from it2hys.policy import PHYSICS
from it2hys.records.clues import Clues


class HumEvidence(EffectEvidence):
    """One narrow line in the residuals of all records that the voltage lacks."""

    meaning = "a line such as the mains' on the reading"
    experiment = "a held voltage (a line that is not in the voltage is there at rest too)"

    by_its_signature = True

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return the residual's three strongest lines; their phases differ from record to record."""
        longest = max(len(c.residual) for c in clues.records)
        frequency, power = clues.spectrum(4 * longest)
        floor = median_filter(power, size=4 * 40 + 1)
        ratio = power / (floor + np.finfo(float).tiny)
        peaks, _ = find_peaks(ratio, distance=12)
        highest = peaks[np.argsort(ratio[peaks])[::-1][:3]]
        least = PHYSICS.line_periods / clues.extent.duration
        return [_fitted_line(clues, frequency[i]) for i in highest if frequency[i] > least]

    def signature(self, clues: Clues) -> Signature | None:
        """Return whether one narrow line is in all residuals that the voltage lacks there.

        The power at each frequency is put over that beside it; under any smooth spectrum the ratio has
        the F distribution, so that the p-value needs no assumption on the noise's colour. The least of
        the records counts, corrected for the number of frequencies; harmonics of a periodic voltage do
        not. The statistic is the share of the residual's power in the line.
        """
        seen = readable(clues)
        if seen is None:
            return None
        frequency, p_values, records = line_ratios(seen)
        if not np.any(records):
            return None
        sure = np.flatnonzero(p_values <= max(1e-6, p_values.min()))
        chosen = sure[np.argmax(seen.spectrum(len(frequency))[1][sure])]
        nearby = frequency[chosen] + frequency[1] * np.linspace(-1.0, 1.0, 9)
        line = max((_fitted_line(seen, f) for f in nearby), key=lambda found: found["hum.amplitude"])
        power = np.mean(np.concatenate([c.residual[c.used] ** 2 for c in seen.records]))
        share = 0.5 * line["hum.amplitude"] ** 2 / max(float(power), np.finfo(float).tiny)
        text = (
            f"The clearest narrow line of the residual is at {line['hum.frequency']:.4g} Hz, of "
            f"{line['hum.amplitude'] * UM:.2g} µm: {100 * share:.0f} % of its power. The voltage has "
            f"no line there in {records[chosen]} of {len(seen.records)} records."
        )
        return Signature(min(share, 1.0), float(p_values[chosen]), text)


def _fitted_line(clues: Clues, frequency: float) -> dict[str, float]:
    """Return the line of this frequency that is in the residuals; each record has its own phase."""
    lines = lines_in(clues, frequency)
    return {
        "hum.amplitude": float(np.median(np.abs(lines))),
        "hum.frequency": float(frequency),
        "hum.phase": np.angle(lines),
    }


EVIDENCE = HumEvidence()
