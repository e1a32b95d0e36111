"""The voltage amplifier driving the capacitance of the stack."""

import math
from dataclasses import dataclass

import numpy as np
import scipy  # its parts are loaded when used

from it2hys.stand.checks import require, require_finite, require_positive


@dataclass(frozen=True)
class Amplifier:
    """First-order amplifier with output limits and a current limit.

    ``dv/dt = clip((target - v) / tau, -I/C, I/C)`` with the target clipped to the supply. Gain
    and output range are the paper's (x15, 0 to 150 V). The paper does not state the other
    values; they are typical of a 7 W piezo amplifier on a stack of 7 x 7 x 20 mm.

    Parameters
    ----------
    gain : float
        Voltage gain.
    low, high : float
        Output limits, V.
    bandwidth : float
        -3 dB frequency on the stack, Hz; ``inf`` for none.
    current : float
        Peak current I, A; ``inf`` for no limit.
    capacitance : float
        Capacitance C of the stack, F.

    Raises
    ------
    InputError
        If a value is out of its domain.
    """

    gain: float = 15.0
    low: float = 0.0
    high: float = 150.0
    bandwidth: float = 4e3
    current: float = 0.3
    capacitance: float = 1.8e-6

    def __post_init__(self):
        """Refuse values out of their domain."""
        require_finite(self, "gain", "low", "high", "capacitance")
        require_positive(self, "gain", "bandwidth", "current", "capacitance")
        require(self, self.low <= 0.0 < self.high, "the output range must contain 0 V")

    @property
    def slew_rate(self):
        """Steepest slope of the output, V/s."""
        return self.current / self.capacitance

    def start(self, step):
        """Give the running amplifier at 0 V; `step` is the fine time step, s."""
        return RunningAmplifier(self, step)


class RunningAmplifier:
    """An amplifier with its output voltage, exact for an input held over each fine step.

    Parameters
    ----------
    amplifier : Amplifier
        The parameters.
    step : float
        Fine time step, s.
    """

    def __init__(self, amplifier, step):
        self._amplifier = amplifier
        self._step = step
        self._rate = 2.0 * math.pi * amplifier.bandwidth  # 1 / time constant
        self._decay = math.exp(-self._rate * step)
        # Below this distance from its target the amplifier is not limited by its current.
        self._linear_range = amplifier.slew_rate / self._rate if self._rate < math.inf else 0.0
        self._voltage = 0.0

    def advance(self, block):
        """Amplify the next samples.

        Parameters
        ----------
        block : numpy.ndarray, shape (n,)
            D/A voltage during each fine step, V.

        Returns
        -------
        numpy.ndarray, shape (n,)
            Stack voltage at the end of each fine step, V.
        """
        amplifier = self._amplifier
        target = np.clip(amplifier.gain * block, amplifier.low, amplifier.high)
        output = self._linear(target)
        if amplifier.slew_rate < math.inf and self._is_limited(target, output):
            output = self._current_limited(target)
        self._voltage = output[-1]
        return output

    def _linear(self, target):
        initial = [self._decay * self._voltage]
        return scipy.signal.lfilter([1.0 - self._decay], [1.0, -self._decay], target, zi=initial)[0]

    def _is_limited(self, target, output):
        """Whether the linear answer asks for more current than there is.

        The distance only shrinks within a step, so its start decides.
        """
        start = np.concatenate([[self._voltage], output[:-1]])
        return np.any(np.abs(target - start) > self._linear_range)

    def _current_limited(self, target):
        limit, slew = self._linear_range, self._amplifier.slew_rate
        output = np.empty_like(target)
        voltage = self._voltage
        for i, goal in enumerate(target.tolist()):
            distance = abs(goal - voltage)
            slewing = min(max((distance - limit) / slew, 0.0), self._step)
            rest = distance - slew * slewing
            if slewing == 0.0:
                rest *= self._decay
            elif slewing < self._step:  # reaches the linear range within this step
                rest = limit * math.exp(-self._rate * (self._step - slewing)) if limit else 0.0
            voltage = goal - math.copysign(rest, goal - voltage)
            output[i] = voltage
        return output
