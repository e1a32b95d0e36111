"""Rate-independent hysteresis of the ceramic: a continuous Preisach operator.

The operator is evaluated through its Everett function, which is closed in form for the density
chosen, so that nothing is discretised: there are as many relays as points in the Preisach plane.
Between two turning points the output is one analytic curve, and only turning points are kept.

References
----------
I. D. Mayergoyz, Mathematical Models of Hysteresis, Springer 1991 (Everett function, wiping-out
and congruency). P. Ge and M. Jouaneh, Modeling hysteresis in piezoceramic actuators, Precision
Engineering 17 (1995) 211-221 (Preisach model of a stack).
"""

from dataclasses import dataclass

import numpy as np

from it2hys.stand.checks import require, require_finite, require_positive


@dataclass(frozen=True)
class Hysteresis:
    r"""Free quasi-static displacement of the stack as a function of its voltage's history.

    ``h = slope v - saturation v^2 + P[v]`` with the Preisach operator P of the density

        mu(alpha, beta) = density exp(-(alpha - beta) / decay + asymmetry (alpha + beta) / 2)

    for relays that switch up at alpha and down at beta. With zero asymmetry P is a
    Prandtl-Ishlinskii operator of exponential density, whose branches mirror each other; the
    asymmetry weights relays of high mean voltage more, so that ascending and descending branches
    differ. The defaults give the paper's range of displacement (0 to 15.5 µm on 0 to 105 V).

    Parameters
    ----------
    slope : float
        Reversible piezoelectric coefficient at 0 V, m/V.
    saturation : float
        Decrease of the reversible coefficient, m/V^2.
    density : float
        Preisach density at the origin, m/V^2; 0 gives a stack without loop.
    decay : float
        Width of the density across the diagonal, V.
    asymmetry : float
        Growth of the density along the diagonal, 1/V, below ``2 / decay`` in absolute value.
    last_peak : float
        Highest voltage that the stack has seen since it was depolarised (all relays of positive
        mean down), V. It then rested at 0 V. Going beyond it leaves a remanent displacement.

    Raises
    ------
    InputError
        If a value is out of its domain.
    """

    slope: float = 101e-9
    saturation: float = 60e-12
    density: float = 1.15e-9
    decay: float = 60.0
    asymmetry: float = 3e-3
    last_peak: float = 65.0

    def __post_init__(self):
        """Refuse values out of their domain."""
        require_finite(self, "slope", "saturation", "decay", "asymmetry")
        require_finite(self, "density", "last_peak", minimum=0.0)
        require_positive(self, "slope", "decay")
        require(self, abs(self.asymmetry) * self.decay < 2.0, "asymmetry must be below 2 / decay")

    def start(self):
        """Give the running operator, at rest at 0 V."""
        return RunningHysteresis(self)

    def reversible(self, voltage):
        """Part without memory, m; `voltage` in V, any shape."""
        return voltage * (self.slope - self.saturation * voltage)

    def everett(self, alpha, beta):
        """Integrate the density over the triangle of relays between two turning points.

        Parameters
        ----------
        alpha, beta : float or numpy.ndarray
            Upper and lower corner, V, ``alpha >= beta``.

        Returns
        -------
        float or numpy.ndarray
            Change of the output when the voltage rises from beta to alpha, m.
        """
        rise = alpha - beta
        down, up = self._exponents()
        scale = self.density * np.exp(self.asymmetry * beta) / up
        return scale * (_integral(self.asymmetry, rise) - _integral(-down, rise))

    def virgin(self, voltage):
        """Give the initial curve from the depolarised state at 0 V.

        Parameters
        ----------
        voltage : float or numpy.ndarray
            Highest (or, below zero, lowest) voltage ever reached, V.

        Returns
        -------
        float or numpy.ndarray
            Output of the Preisach operator, m.
        """
        down, up = self._exponents()
        corner = np.sign(voltage) * np.expm1(-2.0 * np.abs(voltage) / self.decay)
        area = _integral(self.asymmetry, voltage) + corner * self.decay / 2.0
        return self.density / np.where(np.signbit(voltage), down, up) * area

    def _exponents(self):
        """Decay of the density with rising alpha and with falling beta, 1/V."""
        return 1.0 / self.decay - self.asymmetry / 2.0, 1.0 / self.decay + self.asymmetry / 2.0


class RunningHysteresis:
    """A Preisach operator with its memory, the turning points not yet wiped out.

    The output is counted from the state of rest in which it starts.

    Parameters
    ----------
    hysteresis : Hysteresis
        The parameters.
    """

    def __init__(self, hysteresis):
        self._hysteresis = hysteresis
        self._turns = []  # (voltage, Preisach output), alternately maxima and minima
        self._voltage = 0.0
        self._output = 0.0
        self._rising = True
        if hysteresis.last_peak > 0.0:
            self._sweep(np.array([hysteresis.last_peak]), rising=True)
            self._sweep(np.array([0.0]), rising=False)
        self._rest = self._output

    def advance(self, block):
        """Pass the next samples through the operator.

        Parameters
        ----------
        block : numpy.ndarray, shape (n,)
            Stack voltage, V, continuing the previous block; monotone between samples.

        Returns
        -------
        numpy.ndarray, shape (n,)
            Free displacement, m.
        """
        change = np.diff(block, prepend=self._voltage)
        moving = np.flatnonzero(change)
        rising = change[moving] > 0.0
        first = np.flatnonzero(rising[1:] != rising[:-1]) + 1
        starts = [0, *moving[first].tolist()]
        directions = [rising[0] if moving.size else self._rising, *rising[first].tolist()]
        swept = [
            self._sweep(segment, bool(direction))
            for segment, direction in zip(np.split(block, starts[1:]), directions, strict=True)
        ]
        return self._hysteresis.reversible(block) + np.concatenate(swept) - self._rest

    def _sweep(self, segment, rising):
        """Follow a monotone segment, wiping out the turning points that it passes."""
        if rising != self._rising:
            self._turns.append((self._voltage, self._output))
            self._rising = rising
        ordered = segment if rising else -segment
        output = np.empty_like(segment)
        begin = 0
        while True:
            end = np.searchsorted(ordered, self._bound(), side="right")
            output[begin:end] = self._branch(segment[begin:end])
            if end == segment.size:
                break
            del self._turns[-2:]
            begin = end
        self._voltage, self._output = segment[-1], output[-1]
        return output

    def _bound(self):
        """How far the present branch reaches, V, counted in its own direction.

        It ends at the turning point before the last one. The first turning point of all lies on
        the initial curve; its branch ends at the mirror image of that point.
        """
        if not self._turns:
            return np.inf
        if len(self._turns) == 1:
            return abs(self._turns[0][0])
        return self._turns[-2][0] if self._rising else -self._turns[-2][0]

    def _branch(self, voltage):
        if not self._turns:
            return self._hysteresis.virgin(voltage)
        origin, output = self._turns[-1]
        if self._rising:
            return output + self._hysteresis.everett(voltage, origin)
        return output - self._hysteresis.everett(origin, voltage)


def _integral(rate, length):
    """Integrate ``exp(rate x)`` from 0 to `length`."""
    return np.expm1(rate * length) / rate if rate else length
