"""The computer's side of the test stand: D/A and A/D converters and the dead time before them."""

from dataclasses import dataclass

import numpy as np

from it2hys.stand.checks import require, require_finite


@dataclass(frozen=True)
class Converter:
    """Converter that rounds to the nearest of ``2**bits`` levels and clips to its range.

    The defaults are the paper's 16-bit converters with 0 to 10 V.

    Parameters
    ----------
    bits : int
        Resolution, 1 to 32.
    low, high : float
        Voltage of the first code and voltage one quantum above the last, V.

    Raises
    ------
    InputError
        If the resolution or the range is not usable.
    """

    bits: int = 16
    low: float = 0.0
    high: float = 10.0

    def __post_init__(self):
        """Refuse values out of their domain."""
        require_finite(self, "low", "high")
        require(self, self.bits in range(1, 33), f"bits must be 1 to 32, not {self.bits!r}")
        require(self, self.low < self.high, "low must lie below high")

    @property
    def quantum(self):
        """Distance of two neighbouring codes, V."""
        return (self.high - self.low) / 2**self.bits

    def convert(self, volts):
        """Round and clip.

        Parameters
        ----------
        volts : numpy.ndarray, shape (n,)
            Voltages, V.

        Returns
        -------
        numpy.ndarray, shape (n,)
            Voltages of the codes, V.
        """
        codes = np.rint((volts - self.low) / self.quantum)
        return self.low + self.quantum * np.clip(codes, 0, 2**self.bits - 1)


class Delay:
    """A dead time on the fine grid; zero comes out until the first sample has passed.

    Parameters
    ----------
    length : int
        Dead time in fine samples.
    """

    def __init__(self, length):
        self._waiting = np.zeros(length)

    def advance(self, block):
        """Delay the next samples.

        Parameters
        ----------
        block : numpy.ndarray, shape (n,)
            Samples, continuing the previous block.

        Returns
        -------
        numpy.ndarray, shape (n,)
        """
        joined = np.concatenate([self._waiting, block])
        self._waiting = joined[block.size :]
        return joined[: block.size]
