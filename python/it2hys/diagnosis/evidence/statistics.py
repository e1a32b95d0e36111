"""Tests of a property of the residual that hold for coloured residuals.

A property is a set of columns that the residual should follow. What the model itself can do about
them is taken out of both first (`Ground`). Errors of the coefficients are spectral (HAC): the
variance of sum(x e) is the sum over frequencies of the power of x times the power of what is left
of e, smoothed, in each record; the same as the sum over lags of the product of both
autocovariances. An effect has one coefficient for all records: where the records disagree by more
than those errors, the errors are enlarged by as much (Birge's ratio).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar, NamedTuple

import numpy as np
from scipy import stats
from scipy.ndimage import uniform_filter1d
from scipy.optimize import lsq_linear, nnls
from scipy.signal import coherence, find_peaks, lfilter

from it2hys.diagnosis.evidence.base import EffectEvidence
from it2hys.identification.noise import find_period
from it2hys.policy import PHYSICS
from it2hys.records.clues import Clue, Clues

UM = 1e6
#: Fewest samples of a record that can show anything.
FEWEST = 64
#: The residual's power is smoothed over so many frequencies of the Fourier transform ...
_SMOOTHING = 31
#: ... and known with about so many degrees of freedom.
_FREEDOM = 60
#: Blocks into which a record is cut.
_BLOCKS = 16
_RANK_TOLERANCE = 1e-9

Columns = Callable[[Clue], np.ndarray]


@dataclass(frozen=True, eq=False)
class Trial:
    """How the residual follows some columns.

    Parameters
    ----------
    coefficients, errors : ndarray, shape (K,)
        In the unit of the residual over that of the columns; standard errors.
    statistic : float
        Wald's, over K: about 1 where there is nothing, t^2 of a single column.
    p_value : float
        Two-sided.
    share : float
        Share of the residual's power, less what the model can do itself, that the columns explain.
    """

    coefficients: np.ndarray
    errors: np.ndarray
    statistic: float
    p_value: float
    share: float


class Ground:
    """The residuals of all records, less what the model can do about them itself.

    Parameters
    ----------
    clues : Clues
        Those long enough to show something; see `readable`.
    others : sequence of callable, optional
        Columns by record that are taken out as well, beside a constant per record.
    """

    def __init__(self, clues: Clues, others: Sequence[Columns] = ()):
        self._records = clues.records
        ends = np.cumsum([len(c.residual) for c in self._records])
        self._parts = [slice(e - len(c.residual), e) for c, e in zip(self._records, ends, strict=True)]
        self._used = np.concatenate([c.used for c in self._records])
        self._basis = self._orthonormal(others)
        self._residual = self._reduced(np.concatenate([c.residual for c in self._records])[:, None])[
            :, 0
        ]

    def _stacked(self, columns: Columns) -> np.ndarray:
        parts = [columns(c) for c in self._records]
        return np.vstack([p[:, None] if p.ndim == 1 else p for p in parts])

    def _orthonormal(self, others: Sequence[Columns]) -> np.ndarray:
        constants = np.zeros((len(self._used), len(self._parts)))
        for i, part in enumerate(self._parts):
            constants[part, i] = 1.0
        stacked = np.hstack([constants, *(self._stacked(o) for o in others)])
        stacked *= self._used[:, None]
        stacked /= np.maximum(np.linalg.norm(stacked, axis=0), np.finfo(float).tiny)
        q, r = np.linalg.qr(stacked)
        return q[:, np.abs(np.diag(r)) > _RANK_TOLERANCE]

    def _reduced(self, stacked: np.ndarray) -> np.ndarray:
        stacked = stacked * self._used[:, None]
        return stacked - self._basis @ (self._basis.T @ stacked)

    def best(self, bank: Sequence[Columns], positive: bool = False) -> tuple[int, Trial]:
        """Return which member of a bank explains most, and its trial, corrected for the choice.

        Parameters
        ----------
        bank : sequence of callable
            Columns to choose from.
        positive : bool
            Whether only members whose first coefficient is positive count.
        """
        explained = [self._explained(self._stacked(columns), positive) for columns in bank]
        chosen = int(np.argmax(explained))
        if explained[chosen] > 0.0:
            trial = self._trial(self._usable(self._stacked(bank[chosen])))
        else:
            trial = self._trial(None)
        return chosen, replace(trial, p_value=min(1.0, len(bank) * trial.p_value))

    def _usable(self, stacked: np.ndarray) -> np.ndarray | None:
        """Return columns without what is taken out, or None where hardly anything is left."""
        reduced = self._reduced(stacked)
        whole = np.linalg.norm(stacked * self._used[:, None], axis=0)
        left = np.linalg.norm(reduced, axis=0) > 1e-4 * whole
        # what has faded so far that its square is nothing is not there
        return reduced if np.all(left & (whole > np.sqrt(np.finfo(float).tiny))) else None

    def _explained(self, stacked: np.ndarray, positive: bool) -> float:
        """Return by how much columns lower the sum of squares; 0 where hardly any of them is left."""
        x = stacked * self._used[:, None]
        taken = self._basis.T @ x
        whole = x.T @ x
        left = whole - taken.T @ taken
        # the square of what `_usable` asks for
        if not np.all(np.diag(left) > 1e-8 * np.diag(whole)):
            return 0.0
        product = x.T @ self._residual
        coefficients = np.linalg.lstsq(left, product, rcond=_RANK_TOLERANCE)[0]
        return 0.0 if positive and coefficients[0] < 0.0 else float(product @ coefficients)

    def test(self, columns: Columns) -> Trial:
        """Return how the residual follows columns that were not chosen by looking at it."""
        return self._trial(self._usable(self._stacked(columns)))

    def response(self, columns: Columns) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return how residual and model follow many columns.

        Returns
        -------
        normal : ndarray, shape (K, K)
            Normal matrix of the columns.
        information : ndarray, shape (K, K)
            Inverse of the covariance of the residual's coefficients.
        coefficients : ndarray, shape (K, 2)
            Of the residual and of the model's reading.
        """
        x = self._reduced(self._stacked(columns))
        targets = np.column_stack([self._residual, self._reduced(self._stacked(modelled))])
        normal = x.T @ x
        coefficients = np.linalg.lstsq(normal, x.T @ targets, rcond=_RANK_TOLERANCE)[0]
        left = self._residual - x @ coefficients[:, 0]
        scatters = [_scatter(x[part], left[part]) for part in self._parts]
        scores = [x[part].T @ left[part] for part in self._parts]
        scatter = sum(scatters) * _disagreement(scores, scatters)
        return normal, normal @ np.linalg.pinv(scatter, rcond=_RANK_TOLERANCE) @ normal, coefficients

    @property
    def power(self) -> float:
        """Sum of squares of the residuals, less what was taken out."""
        return float(self._residual @ self._residual)

    def _trial(self, x: np.ndarray | None) -> Trial:
        if x is None:
            return Trial(np.zeros(1), np.full(1, np.inf), 0.0, 1.0, 0.0)
        size, bread = x.shape[1], np.linalg.pinv(x.T @ x, rcond=_RANK_TOLERANCE)
        coefficients = bread @ (x.T @ self._residual)
        left = self._residual - x @ coefficients
        scores = [x[part].T @ left[part] for part in self._parts]
        spectral = [_scatter(x[part], left[part]) for part in self._parts]
        blocks = [_block_scatter(x[part] * left[part, None]) for part in self._parts]
        # the spectrum knows colour, blocks know noise that comes and goes: the larger error counts
        covariance, wald = bread, np.inf
        for scatters in (spectral, blocks):
            trial = bread @ sum(scatters) @ bread * _disagreement(scores, spectral)
            statistic = float(coefficients @ np.linalg.pinv(trial, rcond=1e-12) @ coefficients) / size
            if statistic < wald:
                covariance, wald = trial, statistic
        errors = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
        share = 1.0 - float(left @ left) / self.power if self.power > 0.0 else 0.0
        return Trial(coefficients, errors, wald, float(stats.f.sf(wald, size, _FREEDOM)), share)


def _scatter(x: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Return the covariance of x^T e for noise e that has the spectrum of what is left, (K, K)."""
    power = np.abs(np.fft.fft(left)) ** 2 / len(left)
    power = uniform_filter1d(power, min(_SMOOTHING, len(left)), mode="wrap")
    transform = np.fft.fft(x, axis=0)
    return np.real(transform.conj().T @ (power[:, None] * transform)) / len(left)


def spectral_variance(x: np.ndarray, z: np.ndarray) -> float:
    """Return the variance of sum(x z) for an x (N,) that a coloured z (N,) does not depend on."""
    return float(_scatter(x[:, None], z)[0, 0])


def _block_scatter(scores: np.ndarray) -> np.ndarray:
    """Return the covariance of a sum of scores from sums over blocks of samples, (K, K)."""
    length = -(-len(scores) // _BLOCKS)
    sums = np.add.reduceat(scores, np.arange(0, len(scores), length), axis=0)
    sums = sums - sums.mean(axis=0)
    return sums.T @ sums


def _disagreement(scores: list[np.ndarray], scatters: list[np.ndarray]) -> float:
    """Return by how much the records' scores vary more than their scatter allows, at least 1."""
    counted = [(s, v) for s, v in zip(scores, scatters, strict=True) if np.trace(v) > 0.0]
    if len(counted) < 2:
        return 1.0
    excess = sum(float(s @ np.linalg.pinv(v, rcond=1e-12) @ s) for s, v in counted)
    return max(1.0, excess / (len(scores[0]) * (len(counted) - 1)))


def rms(x: np.ndarray) -> float:
    """Return the root mean square; 0 of nothing."""
    return float(np.sqrt(np.mean(x**2))) if len(x) else 0.0


def walked(clues: Clues, first: np.ndarray, move: Callable) -> list[np.ndarray]:
    """Return what an element without time makes of each record's voltage, (N, K) each.

    Parameters
    ----------
    clues : Clues
    first : ndarray, shape (R, K)
        Outputs at the first samples.
    move : callable
        Takes the outputs (R, K) and the voltages (R, 1), returns the next outputs.
    """
    longest = max(len(c.voltage) for c in clues.records)
    padded = [np.pad(c.voltage, (0, longest - len(c.voltage)), mode="edge") for c in clues.records]
    outputs = np.empty((longest, *first.shape))
    for k, voltage in enumerate(np.array(padded).T):
        outputs[k] = first = move(first, voltage[:, None])
    return [outputs[: len(c.voltage), i] for i, c in enumerate(clues.records)]


def by_record(clues: Clues, values: Sequence[np.ndarray]) -> Columns:
    """Return as columns what was computed for every record beforehand."""
    known = {id(c): v for c, v in zip(clues.records, values, strict=True)}
    return lambda clue: known[id(clue)]


def readable(clues: Clues) -> Clues | None:
    """Return the clues of the records that are long enough to show something; None where none is."""
    records = [c for c in clues.records if np.count_nonzero(c.used) >= FEWEST]
    return Clues(clues.extent, records) if records else None


def modelled(clue: Clue) -> np.ndarray:
    """Return the model's reading, (N,): unlike the measured one it has no noise."""
    return clue.displacement - clue.residual


def scaled(clues: Clues, clue: Clue) -> np.ndarray:
    """Return the model's reading in -1 .. 1 over the travel, (N,)."""
    low, high = clues.extent.displacement
    return (modelled(clue) - 0.5 * (low + high)) / (0.5 * (high - low))


def lagged(x: np.ndarray, ticks: float) -> np.ndarray:
    """Return a first-order lag of a signal, from rest at its first value; time constant in ticks."""
    pole = np.exp(-1.0 / ticks)
    return lfilter([1.0 - pole], [1.0, -pole], x, zi=[pole * x[0]])[0]


def delayed(x: np.ndarray, ticks: float) -> np.ndarray:
    """Return a signal some ticks ago, straight between them."""
    places = np.arange(len(x)) - ticks
    return np.interp(places, np.arange(len(x)), x)


def moved(x: np.ndarray) -> np.ndarray:
    """Return by how much a signal changed since the last tick; 0 at first."""
    return np.diff(x, prepend=x[:1])


def absorbed(clues: Clues) -> Columns:
    """Return what a fit of the rules can do itself: a bent static curve, another quickness."""

    def columns(clue: Clue) -> np.ndarray:
        level, change = scaled(clues, clue), moved(scaled(clues, clue))
        curve = [level, level**2, level**3]
        slower = [lagged(change, ticks) for ticks in (3.0, 10.0)]
        return np.column_stack([*curve, *slower, level * slower[1]])

    return columns


# --- what a reader can check by eye -------------------------------------------------------------------

_HOLD = 30


def loop_widths(clues: Clues) -> tuple[np.ndarray, np.ndarray]:
    """Return frequency, Hz, and mean width, m, of the residual's loop over each cycle of the voltage.

    A cycle goes from one minimum of the voltage to the next; the width is positive where the
    residual is higher on the way down, as memory has it.
    """
    least, cycles = PHYSICS.cycle_swing * clues.extent.voltage_span, []
    for clue in clues.records:
        turns, _ = find_peaks(-clue.voltage, prominence=least)
        for first, last in pairwise(turns):
            part = slice(first, last + 1)
            voltage, residual = clue.voltage[part], clue.residual[part]
            # steps are no branch
            if not np.all(clue.used[part]) or np.max(np.abs(np.diff(voltage))) > 0.3 * np.ptp(voltage):
                continue
            area = -np.sum(0.5 * (residual[1:] + residual[:-1]) * np.diff(voltage))
            cycles.append((1.0 / ((last - first) * clues.extent.sample_time), area / np.ptp(voltage)))
    table = np.array(cycles).reshape(-1, 2)
    return table[:, 0], table[:, 1]


def after_steps(clues: Clues) -> float | None:
    """Return by which share of a step the residual grows per decade of hold time, or None."""
    products = np.zeros(2)
    for clue in clues.records:
        steps = np.flatnonzero(np.abs(np.diff(clue.voltage)) > 0.05 * clues.extent.voltage_span) + 1
        reading = modelled(clue)
        for first, last in pairwise([*steps, len(clue.voltage)]):
            held = slice(first + _HOLD, last)
            moving = np.ptp(clue.voltage[first:last]) > 0.01 * clues.extent.voltage_span
            if last - first < 4 * _HOLD or moving or not np.all(clue.used[held]):
                continue
            decades = np.log10(np.arange(_HOLD, last - first))
            x = (reading[last - 1] - reading[first - 1]) * (decades - decades.mean())
            products += x @ clue.residual[held], x @ x
    return float(products[0] / products[1]) if products[1] > 0.0 else None


def branches(clues: Clues) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the mean residual on rising and on falling branches by displacement, (B,) each.

    Only bins that both branches reach are kept; None where there are fewer than three or nothing in
    them.
    """
    bins = 20
    level = np.concatenate([scaled(clues, c)[c.used] for c in clues.records])
    direction = np.concatenate([np.sign(np.gradient(modelled(c)))[c.used] for c in clues.records])
    residual = np.concatenate([(c.residual - c.residual[c.used].mean())[c.used] for c in clues.records])
    place = np.clip(((level + 1.0) * 0.5 * bins).astype(int), 0, bins - 1)
    sums, counts = np.zeros((2, bins)), np.zeros((2, bins))
    for row, side in enumerate((1.0, -1.0)):
        chosen = direction == side
        sums[row] = np.bincount(place[chosen], residual[chosen], bins)
        counts[row] = np.bincount(place[chosen], minlength=bins)
    both = np.all(counts >= 5, axis=0)
    if np.count_nonzero(both) < 3:
        return None
    means = sums[:, both] / counts[:, both]
    return (means[0], means[1]) if np.all(np.std(means, axis=1) > 0.0) else None


def coherence_with_voltage(clues: Clues) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies, Hz, (F,), and each record's coherence of residual and voltage, (R, F)."""
    segment = min(512, *(len(c.residual) // 4 for c in clues.records), 512)
    values = []
    for c in clues.records:
        residual = np.where(c.used, c.residual - np.mean(c.residual[c.used]), 0.0)
        # 0 / 0 where either has nothing
        with np.errstate(invalid="ignore", divide="ignore"):
            frequency, value = coherence(
                moved(c.voltage), residual, 1.0 / clues.extent.sample_time, nperseg=segment
            )
        values.append(np.nan_to_num(value))
    return frequency, np.array(values)


# --- lines of the spectrum -----------------------------------------------------------------------

#: Frequencies beside a line, in those of a transform twice the record, that it is put over ...
_BESIDE = (6, 18)
#: ... which are worth about so many degrees of freedom.
_BESIDE_FREEDOM = 12


def line_ratios(clues: Clues) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return how surely the residuals of all records have a line.

    Returns
    -------
    frequency : ndarray, shape (F,)
        Hz.
    p_value : ndarray, shape (F,)
        That all records that count have so much there by chance, corrected for the number of
        frequencies; 1 where fewer than half of them count.
    records : ndarray of int, shape (F,)
        Records that count; those whose voltage may itself have caused a line do not.
    """
    size = 2 * max(len(c.residual) for c in clues.records)
    frequency = np.fft.rfftfreq(size, clues.extent.sample_time)
    ratios = np.full((len(clues.records), len(frequency)), np.nan)
    for row, clue in zip(ratios, clues.records, strict=True):
        power, voltage = (_power(x, size) for x in (_centred(clue), clue.voltage - clue.voltage.mean()))
        row[:] = power / _beside(power)
        row[voltage / _beside(voltage) > PHYSICS.voltage_line] = np.nan
        period = find_period(clue.voltage)
        if period is not None:
            order = frequency * period * clues.extent.sample_time
            away = np.abs(order - np.round(order)) * size / period
            row[away < _BESIDE[0]] = np.nan
    ratios[:, : _BESIDE[1]] = ratios[:, -_BESIDE[1] :] = np.nan
    counted = np.count_nonzero(np.isfinite(ratios), axis=0)
    enough = counted >= 0.5 * len(clues.records)
    # a record that does not count must not lower the least
    least = np.min(np.where(np.isfinite(ratios), ratios, np.inf), axis=0)
    place = int(np.argmax(np.where(enough & np.isfinite(least), least, 0.0)))
    counting = [
        c for c, ratio in zip(clues.records, ratios[:, place], strict=True) if np.isfinite(ratio)
    ]
    least[place] = min((_over_the_rest(c, place, size) for c in counting), default=0.0)
    p_value = stats.f.sf(least, 2, _BESIDE_FREEDOM) ** np.maximum(counted, 1)
    p_value = np.where(enough, np.minimum(1.0, len(frequency) * p_value), 1.0)
    return frequency, p_value, counted


def _centred(clue: Clue) -> np.ndarray:
    """Return the residual around its mean, 0 where it is not to be trusted."""
    return np.where(clue.used, clue.residual - clue.residual[clue.used].mean(), 0.0)


def _power(x: np.ndarray, size: int) -> np.ndarray:
    return np.abs(np.fft.rfft(x * np.hanning(len(x)), size)) ** 2


def _beside(power: np.ndarray) -> np.ndarray:
    """Return the power beside each frequency."""
    near, far = (uniform_filter1d(power, 2 * n + 1) * (2 * n + 1) for n in _BESIDE)
    beside = (far - near) / (2.0 * (_BESIDE[1] - _BESIDE[0]))
    return np.maximum(beside, 1e-12 * power.max() + np.finfo(float).tiny)


def _over_the_rest(clue: Clue, place: int, size: int) -> float:
    """Return the power at a frequency over that beside it without the line.

    Samples that are not to be trusted spread a line over its neighbours: a clear one would hide itself.
    """
    residual, angle = _centred(clue), 2.0 * np.pi / size * np.arange(len(clue.residual))
    rests = []
    for order in place + np.linspace(-1.0, 1.0, 9):  # the line may lie between two frequencies
        line = clue.used[:, None] * np.column_stack([np.sin(order * angle), np.cos(order * angle)])
        rests.append(residual - line @ np.linalg.lstsq(line, residual)[0])
    rest = min(rests, key=np.linalg.norm)
    return float(_power(residual, size)[place] / _beside(_power(rest, size))[place])


# --- the residual after a step of the voltage ----------------------------------------------------

#: Ticks after a change of the voltage that are looked at.
LAGS = 48
#: Decays, in ticks, that the core may have.
_QUICKNESS = (0.1, 1.0, 2.0, 3.5, 6.0, 10.0, 17.0, 30.0, 60.0, 200.0)
#: Parameters that a fit of the response has in effect: few of the exponentials count.
_FITTED = 6
#: What maps responses, (..., LAGS).
Stage = Callable[[np.ndarray], np.ndarray]


class Answer(NamedTuple):
    """How a stage changes a response to a step: one for each of some parameters, in ticks."""

    stage: Callable[..., Stage]
    parameters: Sequence


@dataclass(frozen=True, eq=False)
class Dynamics:
    """How well one kind of stage explains the residual's response to steps of the voltage.

    Parameters
    ----------
    parameter : float or tuple of float
        Of the stage that explains most, in ticks.
    share : float
        Share of the residual's power that it explains.
    statistic, p_value : float
        Fall of chi squared, from the model's response or that with the best of the other kinds of
        stage, whichever is lower; and its probability in noise.
    """

    parameter: float | tuple[float, float]
    share: float
    statistic: float
    p_value: float


#: The response without any stage.
_UNCHANGED = Answer(lambda _: lambda x: x, (None,))


class StepResponse:
    """The response to a step of the voltage, by tick, in m/V: the model's, and the residual's.

    The sum of both, the measured one, is that of a stage behind (or before) a core. A core's own is a
    sum of exponentials that approach their ends, none of them falling: it is steepest at once and ever
    less steep. After a delay it begins late, but then steeply; with a lag it begins flat; a resonance
    lets it ring.

    Parameters
    ----------
    clues : Clues
    """

    def __init__(self, clues: Clues):
        ground = Ground(clues, [_old_voltage])
        self._normal, self._information, responses = ground.response(_past_changes)
        self.residual, model = responses.T
        self.measured = model + self.residual
        self._power = ground.power
        values, vectors = np.linalg.eigh(self._information)
        self._root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
        self._target = self._root @ self.measured

    def dynamics(self, own: Answer, others: Sequence[Answer]) -> Dynamics:
        """Return how well one kind of stage explains the response, and others do not."""
        cost, parameter, response = self._fit(*own)
        rivals = [self._fit(*other)[0] for other in (*others, _UNCHANGED)]
        untouched = float(self.residual @ self._information @ self.residual)
        statistic = min(untouched, *rivals) - cost
        error = self.measured - response
        explained = self.residual @ self._normal @ self.residual - error @ self._normal @ error
        sure = stats.f.sf(max(statistic, 0.0) / _FITTED, _FITTED, _FREEDOM)
        p_value = min(1.0, len(own.parameters) * float(sure))
        share = max(0.0, float(explained) / self._power) if self._power > 0.0 else 0.0
        return Dynamics(parameter, share, statistic, p_value)

    def _fit(self, stage: Callable, parameters: Sequence) -> tuple[float, object, np.ndarray]:
        """Return the least chi squared of a kind of stage, its parameter and its response."""
        plain = np.cumsum(np.exp(-np.arange(LAGS) / np.array(_QUICKNESS)[:, None]), axis=1)
        fits = []
        for parameter in parameters:
            shapes = stage(parameter)(plain).T
            weights, chi_squared = _without_negative(self._root @ shapes, self._target)
            fits.append((chi_squared, parameter, shapes @ weights))
        return min(fits, key=lambda fit: fit[0])


def _without_negative(columns: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the best weights that are not negative, shape (K,), and the sum of squares left."""
    try:
        weights, norm = nnls(columns, target)
        return weights, float(norm**2)
    except RuntimeError:  # of columns that are nearly alike, the faster method may go in circles
        fit = lsq_linear(columns, target, (0.0, np.inf), method="bvls")
        # it ends within rounding of its bounds, on either side
        return np.maximum(fit.x, 0.0), float(2.0 * fit.cost)


def _old_voltage(clue: Clue) -> np.ndarray:
    """Return the voltage before those changes and what slower memory keeps of it, (N, 4)."""
    old = delayed(clue.voltage, LAGS)
    return np.column_stack(
        [old, *(lagged(old, ticks) for ticks in (0.5 * LAGS, 2.0 * LAGS, 8.0 * LAGS))]
    )


def _past_changes(clue: Clue) -> np.ndarray:
    """Return the voltage's changes, 0 .. LAGS - 1 ticks ago, (N, LAGS)."""
    change = np.concatenate([np.zeros(LAGS - 1), moved(clue.voltage)])
    return np.lib.stride_tricks.sliding_window_view(change, LAGS)[:, ::-1]


class StepEvidence(EffectEvidence):
    """What is shown by the response to a step, against all others that are.

    Attributes
    ----------
    answer : Answer
        How the effect changes it.
    """

    answer: ClassVar[Answer]

    def dynamics(self, seen: Clues) -> Dynamics:
        """Return how well the effect explains the response, and the others do not."""
        kinds = StepEvidence.__subclasses__()
        others = [kind.answer for kind in kinds if kind is not type(self)]
        return StepResponse(seen).dynamics(self.answer, others)
