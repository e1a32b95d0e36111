"""Whether the displacement answers the voltage as a stage's does: it rises with it, on one branch.

Three kinds of records are refused, because no fit could make anything of them: a displacement that
falls while the voltage rises, one that turns back on its way (a butterfly loop), and one that has
nothing to do with the voltage.

The sign is read off the mean displacement at each voltage: hysteresis, creep and lag part the branches
of a loop, but leave their mean monotone. A butterfly turns back within a branch, and the same way at
opposite voltages; what lags turns back, too, but the opposite way there. Drift is estimated together
with the mean, as are force and temperature where they were recorded. A drift cannot be told from a
response that goes through few swings of the voltage, so that drifts of several orders are tried, none
of which may speak for the stage.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from it2hys.errors import InputError
from it2hys.policy import RESPONSE
from it2hys.records.record import Record

#: Samples that are looked at: a longer record is averaged in blocks, or cut where its drive is fast.
_SAMPLES = 8000
#: Share of the voltage's variance that averaging in blocks has to leave.
_RESOLVED = 0.9
#: Voltages at which the mean displacement is taken; each branch of a loop has half as many.
_LEVELS = 20
#: Share of the voltage's range that a swing goes beyond its middle, on either side.
_SWING = 0.2
#: Largest order of a drift, and swings for each order beyond the second.
_HIGHEST_ORDER, _SWINGS_PER_ORDER = 8, 6
#: Weight, as a share of the samples, of the guess that there is no drift: it decides where voltage and
#: drift rise together.
_NO_DRIFT = 1e-3

#: Share of the displacement that is no more than rounding.
_ROUNDING = 1e-9
#: Past displacements and voltages, in samples, from which the next displacement is predicted.
_OWN_PAST, _PAST = 6, (0, 1, 2, 4, 8, 16, 32)

#: Fewest samples that can be trusted of which anything is said.
_FEWEST_TRUSTED = 20


def check_response(record: Record) -> None:
    """Refuse a record whose displacement does not answer the voltage as a stage's does.

    Raises
    ------
    InputError
        If the displacement falls while the voltage rises, is not monotone in it, or has nothing to do
        with it. Records of which that is not certain pass.
    """
    trusted = ~record.outliers
    if np.count_nonzero(trusted) < _FEWEST_TRUSTED:
        return
    if np.ptp(record.voltage[trusted]) == 0.0 or np.ptp(record.displacement[trusted]) == 0.0:
        return
    seen = _Seen.of(record)
    explained, chance = _relation(seen)
    if explained < RESPONSE.plain and chance > RESPONSE.chance:
        raise _fault(record, _unrelated_text(explained))
    views = [_Curve.of(seen, order) for order in seen.orders]
    if np.min(seen.voltage) < 0.0 < np.max(seen.voltage) and all(_is_folded(c) for c in views):
        rising, falling = views[0].branches
        raise _fault(record, _folded_text(rising if rising.folded > RESPONSE.folded else falling))
    if all(_is_reversed(c, explained, seen) for c in views):
        raise _fault(record, _reversed_text(views[0], record))


def _fault(record: Record, message: str) -> InputError:
    place = f"record '{record.name}'" if record.path is None else f"{record.path}"
    return InputError(f"{place}: {message}")


# --- what is looked at ---------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Seen:
    """What is looked at of a record.

    Parameters
    ----------
    voltage, displacement : ndarray, shape (n,)
        V and µm.
    others : ndarray, shape (n, k)
        Force and temperature, each within -1 .. 1, where they were recorded.
    block : int
        Samples of the record in each of these.
    swings : int
        How often the voltage goes from one side of its range to the other.
    """

    voltage: np.ndarray
    displacement: np.ndarray
    others: np.ndarray
    block: int
    swings: int

    @classmethod
    def of(cls, record: Record) -> _Seen:
        trusted = ~record.outliers
        channels = [record.voltage, 1e6 * record.displacement, record.force, record.temperature]
        signals = np.column_stack([c[trusted] for c in channels if c is not None and np.ptp(c) > 0.0])
        signals, block = _shortened(signals)
        others = signals[:, 2:] - signals[:, 2:].mean(axis=0)
        others = others / np.maximum(np.abs(others).max(axis=0), np.finfo(float).tiny)
        voltage = signals[:, 0]
        return cls(voltage, signals[:, 1], others, block, _swings(voltage))

    @property
    def orders(self) -> tuple[int, ...]:
        """Orders of the drifts that these swings may be mistaken for."""
        if self.swings < 2:
            return (0,)
        if self.swings < 4:
            return (0, 1)
        return (1, min(2 + self.swings // _SWINGS_PER_ORDER, _HIGHEST_ORDER))

    @property
    def cycle(self) -> float:
        """Mean length of a cycle of the voltage, in entries."""
        return 2.0 * len(self.voltage) / max(self.swings, 1)

    def disturbances(self, order: int) -> np.ndarray:
        """Return a constant, the other channels and a drift up to an order, shape (n, K)."""
        time = np.linspace(-1.0, 1.0, len(self.voltage))
        return np.column_stack([np.polynomial.legendre.legvander(time, order), self.others])


def _shortened(signals: np.ndarray) -> tuple[np.ndarray, int]:
    """Return signals, (n, k), in at most so many entries, and the samples in each."""
    block = -(-len(signals) // _SAMPLES)
    whole = len(signals) // block * block
    means = signals[:whole].reshape(-1, block, signals.shape[1]).mean(axis=1)
    if np.var(means[:, 0]) >= _RESOLVED * np.var(signals[:, 0]):
        return means, block
    parts = [signals[k : k + _SAMPLES] for k in range(0, len(signals) - _SAMPLES + 1, _SAMPLES)]
    return max(parts, key=lambda part: np.var(part[:, 0])), 1


def _swings(voltage: np.ndarray) -> int:
    beyond = voltage - 0.5 * (voltage.min() + voltage.max())
    clear = np.abs(beyond) > _SWING * np.ptp(voltage)
    return int(np.count_nonzero(np.diff(np.sign(beyond[clear]))))


# --- whether there is a relation -----------------------------------------------------------------


def _relation(seen: _Seen) -> tuple[float, float]:
    """Return the share of the displacement that the voltage explains, and how likely that is chance.

    Two tests that noise of any colour passes by chance alone: whether the loops, or the voltage at the
    lag that suits best, explain more than independent samples of their residual would; and whether the
    voltage helps to predict the next displacement from those before it.
    """
    pairs = [_by_loops(seen, seen.disturbances(order)) for order in seen.orders]
    shares, chances = zip(*pairs, strict=True)
    return max(shares), min(*chances, _by_prediction(seen))


def _by_loops(seen: _Seen, disturbances: np.ndarray) -> tuple[float, float]:
    """Return share and chance of what voltage, branch and the best lag explain."""
    voltage, count = seen.voltage, len(seen.voltage)
    level = _levels(voltage, _LEVELS // 2) + _LEVELS // 2 * (np.gradient(voltage) >= 0.0)
    branches = (level[:, None] == np.arange(_LEVELS)).astype(float)
    known = _basis(disturbances)
    rest = seen.displacement - known @ (known.T @ seen.displacement)
    if np.linalg.norm(rest) < _ROUNDING * np.linalg.norm(seen.displacement):
        return 0.0, 1.0
    scaled = (voltage - voltage.mean()) / voltage.std()
    late = [_lagged(x, _best_lag(rest, x)) for x in (scaled, scaled**2)]
    every = _basis(np.column_stack([known, scaled, branches, *late]))
    left = rest - every @ (every.T @ rest)
    share = float(left @ left / (rest @ rest))
    explained = 1.0 - share * (count - known.shape[1]) / max(count - every.shape[1], 1)
    correlation = np.clip((left[1:] @ left[:-1]) / max(left @ left, np.finfo(float).tiny), 0.0, 1.0)
    independent = count * (1.0 - correlation) / (1.0 + correlation)
    return explained, _chance(
        1.0 - share, share, every.shape[1] - known.shape[1], independent - every.shape[1], count
    )


def _by_prediction(seen: _Seen) -> float:
    """Return how likely it is chance that past voltages help past displacements to predict the next."""
    count, rows = len(seen.voltage), slice(_OWN_PAST, None)
    scaled = (seen.voltage - seen.voltage.mean()) / seen.voltage.std()
    own = [_lagged(seen.displacement, k) for k in range(1, _OWN_PAST + 1)]
    known = _basis(np.column_stack([seen.disturbances(1), *own])[rows])
    target = seen.displacement[rows]
    surprise = target - known @ (known.T @ target)
    slow = _basis(seen.disturbances(1)[rows])
    rest = target - slow @ (slow.T @ target)
    if np.linalg.norm(rest) < _ROUNDING * np.linalg.norm(target):
        return 1.0
    if np.linalg.norm(surprise) < RESPONSE.regular * np.linalg.norm(rest):
        return 0.0
    best = _best_lag(surprise, scaled[rows])
    lags = [k for k in sorted({*_PAST, best, best + 1}) if k < count // 4]
    past = [_lagged(scaled, k) for k in lags] + [_lagged(scaled**2, k) for k in (0, 1)]
    every = _basis(np.column_stack([known, *(p[rows] for p in past)]))
    left = target - every @ (every.T @ target)
    return _chance(
        surprise @ surprise - left @ left,
        left @ left,
        every.shape[1] - known.shape[1],
        len(target) - every.shape[1],
        count,
    )


def _chance(explained: float, left: float, terms: int, freedom: float, lags: int) -> float:
    """Return the p-value of the F test, of the best of a quarter of the lags."""
    if terms <= 0 or freedom <= 0.0 or left <= 0.0:
        return 1.0
    from scipy import stats  # large, and a file is refused before

    p_value = stats.f.sf(explained / terms / (left / freedom), terms, freedom)
    return float(min(1.0, p_value * max(lags // 4, 1)))


def _basis(columns: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis of the span of columns."""
    sizes = np.linalg.norm(columns, axis=0)
    basis, singular, _ = np.linalg.svd(
        columns[:, sizes > 0.0] / sizes[sizes > 0.0], full_matrices=False
    )
    return basis[:, singular > 1e-7 * singular[0]]


def _lagged(values: np.ndarray, samples: int) -> np.ndarray:
    return np.concatenate([np.full(samples, values[0]), values[: len(values) - samples]])


def _cross_correlation(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the sums of y[k + lag] x[k], means removed, by lag; negative lags from the end."""
    size = 2 * len(y)
    spectra = (np.fft.rfft(v - v.mean(), size) for v in (y, x))
    return np.fft.irfft(next(spectra) * np.conj(next(spectra)), size)


def _best_lag(y: np.ndarray, x: np.ndarray) -> int:
    """Return the lag, up to a quarter of the record, at which y is most like x or its opposite."""
    return int(np.argmax(np.abs(_cross_correlation(y, x)[: max(len(y) // 4, 2)])))


# --- which way it goes ---------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Branch:
    """The mean displacement at each voltage while that rises, or while it falls.

    Parameters
    ----------
    level : ndarray of int, shape (L,)
        Levels of the voltage that occur.
    voltage, displacement : ndarray, shape (L,)
        V and µm, in the order in which they are gone through.
    folded : float
        Share of its shape that no monotone one explains.
    left : float
        Sum of the squares that the means leave, µm².
    """

    level: np.ndarray
    voltage: np.ndarray
    displacement: np.ndarray
    folded: float
    left: float

    @classmethod
    def of(cls, voltage: np.ndarray, displacement: np.ndarray, rising: bool) -> _Branch:
        here = (np.gradient(voltage) >= 0.0) == rising
        levels, place = np.unique(_levels(voltage, _LEVELS)[here], return_inverse=True)
        counts = np.bincount(place)
        means = [np.bincount(place, values[here]) / counts for values in (voltage, displacement)]
        turns = (_not_monotone(means[1], counts, way) for way in (True, False))
        folded = min(turns) if len(levels) > 1 else 0.0
        left = float(np.sum((displacement[here] - means[1][place]) ** 2))
        way = slice(None, None, 1 if rising else -1)
        return cls(levels[way], means[0][way], means[1][way], folded, left)


@dataclass(frozen=True, eq=False)
class _Curve:
    """The mean displacement at each voltage, a drift of some order estimated with it.

    Parameters
    ----------
    voltage, displacement : ndarray, shape (L,)
        V and um, in the order of the voltage.
    explained : float
        Share of the displacement, less the drift, that it accounts for.
    not_rising, not_falling : float
        Shares of its shape that none which rises, and none which falls, explains.
    without_drift : ndarray, shape (n,)
        The displacement, µm.
    branches : tuple of _Branch
        Of that, the rising and the falling one.
    """

    voltage: np.ndarray
    displacement: np.ndarray
    explained: float
    not_rising: float
    not_falling: float
    without_drift: np.ndarray
    branches: tuple[_Branch, _Branch]

    @classmethod
    def of(cls, seen: _Seen, order: int) -> _Curve:
        levels, place = np.unique(_levels(seen.voltage, _LEVELS), return_inverse=True)
        at_level = (place[:, None] == np.arange(len(levels))).astype(float)
        others = seen.disturbances(order)[:, 1:]
        guess = np.sqrt(_NO_DRIFT * len(place)) * np.eye(
            others.shape[1], len(levels) + others.shape[1], len(levels)
        )
        solution = np.linalg.lstsq(
            np.vstack([np.hstack([at_level, others]), guess]),
            np.concatenate([seen.displacement, np.zeros(len(guess))]),
            rcond=None,
        )[0]
        curve = solution[: len(levels)]
        rest = seen.displacement - others @ solution[len(levels) :]
        counts = at_level.sum(axis=0)
        freedom = (len(rest) - 1) / max(len(rest) - len(curve), 1)
        return cls(
            at_level.T @ seen.voltage / counts,
            curve,
            float(1.0 - np.var(rest - curve[place]) / np.var(rest) * freedom),
            _not_monotone(curve, counts, rising=True),
            _not_monotone(curve, counts, rising=False),
            rest,
            (_Branch.of(seen.voltage, rest, True), _Branch.of(seen.voltage, rest, False)),
        )


def _not_monotone(curve: np.ndarray, counts: np.ndarray, rising: bool) -> float:
    """Return the share of a curve's variance that the best monotone one leaves."""
    from scipy import optimize

    monotone = optimize.isotonic_regression(curve, weights=counts, increasing=rising).x
    power = counts @ (curve - np.average(curve, weights=counts)) ** 2
    return float(counts @ (curve - monotone) ** 2 / max(power, np.finfo(float).tiny))


def _levels(voltage: np.ndarray, count: int) -> np.ndarray:
    """Return the number of each voltage's level, 0 .. count - 1, over the range."""
    share = (voltage - voltage.min()) / np.ptp(voltage)
    return np.minimum((share * count).astype(int), count - 1)


def _matters(curve: _Curve, explained: float) -> bool:
    return curve.explained > max(RESPONSE.shows, RESPONSE.matters * explained)


def _is_folded(curve: _Curve) -> bool:
    """Return whether a plain branch turns back, and both go the same way at opposite voltages."""
    branches, whole = curve.branches, curve.without_drift
    plain = sum(b.left for b in branches) < (1.0 - RESPONSE.plain) * len(whole) * np.var(whole)
    if not plain or max(b.folded for b in branches) < RESPONSE.folded:
        return False
    rising, falling = ({k: y for k, y in zip(b.level, b.displacement, strict=True)} for b in branches)
    both = [(y, falling[_LEVELS - 1 - k]) for k, y in rising.items() if _LEVELS - 1 - k in falling]
    if len(both) < _LEVELS // 2:
        return False
    here, opposite = np.transpose(both)
    even, odd = np.var(here + opposite), np.var(here - opposite)
    return bool(even > RESPONSE.even * (even + odd))


def _is_reversed(curve: _Curve, explained: float, seen: _Seen) -> bool:
    """Return whether a curve falls, and the opposite of the displacement lags as a stage does."""
    if not (
        _matters(curve, explained)
        and curve.not_falling < RESPONSE.falls
        and curve.not_rising > RESPONSE.not_rises
        and seen.cycle * seen.block >= RESPONSE.fewest_in_cycle
    ):
        return False
    reach = int(np.clip(seen.cycle / 2, 2, len(seen.voltage) // 4))
    lags = np.arange(-reach, reach + 1)
    later = lags[np.argmax(_cross_correlation(-curve.without_drift, seen.voltage)[lags])]
    return bool(-later <= max(1.0, RESPONSE.lead * seen.cycle))


# --- in words ------------------------------------------------------------------------------------


def _unrelated_text(explained: float) -> str:
    return (
        f"the voltage explains {100 * max(explained, 0.0):.2g} % of the displacement, no more than "
        "chance, whatever the lag or the memory: the sensor read noise or another disturbance. Check "
        "that both columns were recorded together, the amplifier was on and the sensor saw the stage"
    )


def _folded_text(branch: _Branch) -> str:
    v, y = branch.voltage, branch.displacement
    chord = np.interp(np.abs(v - v[0]), np.abs(v[[0, -1]] - v[0]), y[[0, -1]])
    turn = int(np.argmax(np.abs(y - chord)))
    way = "falls and rises again" if y[turn] < chord[turn] else "rises and falls again"
    goes = "rises" if v[-1] > v[0] else "falls"
    places = [f"{y[i]:.4g} µm at {v[i]:.4g} V" for i in (0, turn, -1)]
    return (
        f"the displacement {way} while the voltage {goes}: on average it is {places[0]}, {places[1]} "
        f"and {places[2]}. That is a butterfly loop, of a stage driven beyond its coercive field, and "
        "the model holds for one branch of it: drive the stage on one side of zero volts, where the "
        "displacement rises with the voltage"
    )


def _reversed_text(curve: _Curve, record: Record) -> str:
    low, high = record.voltage.min(), record.voltage.max()
    levels, ends = curve.voltage, curve.displacement[[0, -1]]
    fall = (ends[0] - ends[1]) * (high - low) / (levels[-1] - levels[0])
    measured = (
        f"the displacement falls by {fall:.3g} µm while the voltage rises from {low:.4g} to "
        f"{high:.4g} V: "
    )
    if record.inverted:
        return measured + "its sign was right before it was inverted; leave out --invert-displacement"
    return (
        measured + "the sensor's sign is reversed, or the stage pulls; add --invert-displacement "
        "(in Python invert_displacement=True)"
    )
