"""Linear dynamics as a parallel bank of first-order modes, exact for piecewise linear input."""

import numpy as np
import scipy  # its parts are loaded when used

# Up to this many samples a matrix product beats one call of lfilter per mode.
_LONGEST_LIFTED_BLOCK = 64


class ModeBank:
    r"""Sum of first-order modes with a direct path, ``y = d u + Re(sum c_i s_i)``.

    Each mode follows ``ds_i/dt = lambda_i (s_i - u)``, so that its static gain is one. A real
    pole is a relaxation; a complex pole stands for itself and its conjugate. The input is taken
    as linear between samples (first-order hold), for which the recursion is exact.

    Parameters
    ----------
    poles : array_like, shape (m,), real or complex
        Poles lambda_i, 1/s, with negative real part.
    gains : array_like, shape (m,)
        Static gains c_i.
    direct : float
        Direct gain d.
    step : float
        Distance of the samples, s.

    Notes
    -----
    All states and the input before the first sample are zero. The discretisation is the
    triangle-hold equivalent of Franklin, Powell and Workman, Digital Control of Dynamic Systems.
    """

    def __init__(self, poles, gains, direct, step):
        exponent = np.atleast_1d(poles) * step
        growth = np.expm1(exponent)
        mean = growth / exponent
        self._gains = np.atleast_1d(gains)
        self._direct = direct
        self._decay = np.exp(exponent)
        self._now = 1.0 - mean  # weight of the newest input in s
        self._before = mean - self._decay  # weight of the input one sample earlier
        self._state = np.zeros(exponent.size, dtype=exponent.dtype)
        self._lifted = {}

    def advance(self, block):
        """Pass the next samples through the bank.

        Parameters
        ----------
        block : numpy.ndarray, shape (n,)
            Input samples, continuing the previous block.

        Returns
        -------
        numpy.ndarray, shape (n,)
        """
        if block.size <= _LONGEST_LIFTED_BLOCK:
            return self._advance_lifted(block)
        output = self._direct * block
        for i, gain in enumerate(self._gains):
            mode, final = scipy.signal.lfilter(
                [self._now[i], self._before[i]],
                [1.0, -self._decay[i]],
                block,
                zi=self._state[i : i + 1],
            )
            self._state[i] = final[0]
            output += (gain * mode).real
        return output

    def _advance_lifted(self, block):
        output_of_state, output_of_input, decay, state_of_input = self._lift(block.size)
        output = (output_of_state @ self._state).real + output_of_input @ block
        self._state = decay * self._state + state_of_input @ block
        return output

    def _lift(self, length):
        """Matrices of `length` steps at once, for the state kept in lfilter's transposed form."""
        if length not in self._lifted:
            powers = self._decay ** np.arange(length + 1)[:, None]
            into_state = self._before + self._decay * self._now
            pulse = np.empty(length)
            pulse[0] = self._direct + (self._gains @ self._now).real
            pulse[1:] = (powers[: length - 1] @ (self._gains * into_state)).real
            lag = np.subtract.outer(np.arange(length), np.arange(length))
            self._lifted[length] = (
                powers[:length] * self._gains,
                np.where(lag >= 0, pulse[lag], 0.0),
                powers[length],
                (powers[:length][::-1] * into_state).T,
            )
        return self._lifted[length]
