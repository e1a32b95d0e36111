"""A line on the reading that is not in the voltage.

For it speaks one narrow line in the residual's spectrum, of the same frequency and amplitude in every
record, where the voltage has none: incoherent with it, there in rest as in motion.
"""

import math

import casadi as ca
import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import find_peaks

from it2hys.effects import Clues, Extent, Scalar, Signature, Start, Surroundings, Values
from it2hys.effects.statistics import UM, line_ratios, readable

#: Periods within the longest record below which a slow motion is no line.
LEAST_PERIODS = 5.0

#: What the effect is, in plain words.
MEANING = "a line such as the mains' on the reading"
#: What would show the effect apart from others.
EXPERIMENT = "a held voltage (a line that is not in the voltage is there at rest too)"


def is_on(parameters: Values) -> bool:
    """Return whether there is a hum."""
    return parameters["hum.amplitude"] > 0.0


def size(parameters: Values) -> int:
    """Return the number of states: none."""
    return 0


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input at rest. The reading is not part of the state of rest."""
    return y, []


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the reading with the line; time is the tick's own."""
    angle = 2.0 * math.pi * values["hum.frequency"] * around.time + values["hum.phase"]
    return x + values["hum.amplitude"] * ca.sin(angle), []


def starts(extent: Extent) -> dict[str, Start]:
    """Start at the mains' frequency; the line of the residual's spectrum is better."""
    nyquist = 0.5 / extent.sample_time
    return {
        "hum.amplitude": Start(0.001 * extent.displacement_span, 0.0, 0.1 * extent.displacement_span),
        "hum.frequency": Start(min(50.0, 0.5 * nyquist), LEAST_PERIODS / extent.duration, nyquist),
        # an angle has no end; a fit must be able to go round
        "hum.phase": Start(0.0, -100.0, 100.0),
    }


def guesses(clues: Clues, lines: int = 3) -> list[dict[str, float]]:
    """Return the strongest lines of the residual; their phases differ from record to record."""
    longest = max(len(c.residual) for c in clues.records)
    frequency, power = clues.spectrum(4 * longest)
    floor = median_filter(power, size=4 * 40 + 1)
    ratio = power / (floor + np.finfo(float).tiny)
    peaks, _ = find_peaks(ratio, distance=12)
    highest = peaks[np.argsort(ratio[peaks])[::-1][:lines]]
    least = LEAST_PERIODS / clues.extent.duration
    return [_fitted_line(clues, frequency[i]) for i in highest if frequency[i] > least]


def _fitted_line(clues: Clues, frequency: float) -> dict[str, float]:
    """Return the line of this frequency that is in the residuals; each record has its own phase."""
    lines = _lines(clues, frequency)
    return {
        "hum.amplitude": float(np.median(np.abs(lines))),
        "hum.frequency": float(frequency),
        "hum.phase": np.angle(lines),
    }


def phases(clues: Clues, frequency: float) -> np.ndarray:
    """Return the phase of a line in each record's residual, rad."""
    return np.angle(_lines(clues, frequency))


def _lines(clues: Clues, frequency: float) -> np.ndarray:
    """Return the complex amplitudes of a line in the residuals, by least squares."""
    amplitudes = []
    for c in clues.records:
        angle = 2.0 * math.pi * frequency * np.arange(len(c.residual)) * clues.extent.sample_time
        columns = np.column_stack([np.sin(angle), np.cos(angle), np.ones(len(angle))])[c.used]
        sine, cosine, _ = np.linalg.lstsq(columns, c.residual[c.used])[0]
        amplitudes.append(complex(sine, cosine))
    return np.array(amplitudes)


def signature(clues: Clues) -> Signature | None:
    """Return whether one narrow line is in the residuals of all records that the voltage lacks there.

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
        f"A narrow line at {line['hum.frequency']:.4g} Hz of {line['hum.amplitude'] * UM:.2g} µm is "
        "in the residual "
        f"of {records[chosen]} of {len(seen.records)} records, where the voltage has none: "
        f"{100 * share:.0f} % of its power."
    )
    return Signature(min(share, 1.0), float(p_values[chosen]), text)
