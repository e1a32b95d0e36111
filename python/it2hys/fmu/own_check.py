"""What `it2hys effect check` finds out about an effect of the user's own, as rows of a table."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from it2hys.errors import InputError
from it2hys.model import compiled
from it2hys.model.chain import Chain
from it2hys.model.own_effect import AT_REST, ENDS, OwnEffect, line_of, sample_values, symbols_of
from it2hys.model.parameters import ParameterSet, table_1
from it2hys.records import Record

#: Samples of a signal that are checked; further ones of a record are ignored.
_SAMPLES = 4000
#: Ticks for which CasADi runs the whole chain, and those that are timed.
_TICKS, _TIMED = 300, 20_000
#: The most that two ways to compute the same may differ, relative; quotients are less exact.
_SAME, _QUOTIENT = 1e-12, 1e-5


@dataclass(frozen=True)
class Finding:
    """One row: what was tried, what came out, and whether that will do."""

    what: str
    found: str
    good: bool


@dataclass(frozen=True)
class Signals:
    """What an effect is tried on: columns of shape (N,), in SI units."""

    name: str
    sample_time: float
    x: np.ndarray
    around: np.ndarray


def signals_for(effect: OwnEffect, records: Sequence[Record]) -> list[Signals]:
    """Return the effect's inputs in records, or without any, over the range of the paper's stage."""
    if not records:
        low, high = (table_1()[end] for end in ENDS[effect.side])
        ticks = np.arange(_SAMPLES)
        wave = 0.8 * np.sin(0.025 * ticks) + 0.2 * np.sin(0.31 * ticks)
        around = np.tile(np.array(AT_REST)[:, None], len(ticks))
        around[2] = 1e-4 * ticks
        around[3] = table_1()["voltageMax"] * (0.5 + 0.5 * wave)
        return [Signals("Table 1", 1e-4, low + (high - low) * (0.5 + 0.5 * wave), around)]
    found = []
    for r in records:
        x = (r.voltage if effect.side == "before" else r.displacement)[:_SAMPLES]
        force = 0.0 if r.force is None else r.force[:_SAMPLES]
        temperature = AT_REST.temperature if r.temperature is None else r.temperature[:_SAMPLES]
        time = r.sample_time * np.arange(len(x))
        channels = (force, temperature, time, r.voltage[:_SAMPLES])
        around = np.array([np.broadcast_to(c, x.shape) for c in channels])
        found.append(Signals(r.name, r.sample_time, x, around))
    return found


def check_effect(effect: OwnEffect, records: Sequence[Record] = ()) -> list[Finding]:
    """Return what is found; the effect is in the chain.

    Parameters
    ----------
    effect : OwnEffect
        It has passed `load_effect`.
    records : sequence of Record
        Whose range it is tried over.
    """
    rows = [Finding("causality", f"step depends on {', '.join(_depends(effect))} alone", True)]
    signals = signals_for(effect, records)
    for own in signals:
        rows += _over(effect, own)
    return [*rows, *_in_chain(effect)]


def _depends(effect: OwnEffect) -> list[str]:
    values, state, x, around = symbols_of(effect)
    output, following = effect.step(values, list(state), x, around)
    together = ca.vertcat(output, *following)
    return [str(s) for s in (x, *state, *around, *values.values()) if ca.depends_on(together, s)]


def _guesses(effect: OwnEffect) -> list[dict[str, float]]:
    count = max(len(p.guesses) for p in effect.parameters)
    return sample_values(effect, 0)[:count]


class _Run:
    """The effect alone over a signal, for one set of its parameters."""

    def __init__(self, effect: OwnEffect, values: dict[str, float], signals: Signals) -> None:
        symbols, state, x, around = symbols_of(effect)
        output, following = effect.step(symbols, list(state), x, around)
        outputs = ca.vertcat(output, *following)
        p = ca.vertcat(*symbols.values())
        inputs = [p, ca.vertcat(*state), x, ca.vertcat(*around)]
        by = ca.vertcat(p, *state, x)
        step = ca.Function(
            "step", inputs, [ca.vertcat(*following), output, ca.jacobian(output, x), outputs]
        )
        self.slopes = ca.Function("slopes", inputs, [ca.jacobian(outputs, by)])
        self.values = np.array([{**values, "sampleTime": signals.sample_time}[n] for n in symbols])
        self.signals = signals
        ends = dict(zip(ENDS[effect.side], (signals.x.min(), signals.x.max()), strict=True))
        known = {**dict(zip(symbols, self.values, strict=True)), **ends}
        _, rested = effect.rest(known, float(signals.x[0]))
        now = np.array([float(s) for s in rested])
        self.states, self.y, self.slope = [], np.empty(len(signals.x)), np.empty(len(signals.x))
        self.step = step
        for k, place in enumerate(signals.x):
            self.states.append(now)
            following, y, slope, _ = step(self.values, now, place, signals.around[:, k])
            now = np.array(following).ravel()
            self.y[k], self.slope[k] = float(y), float(slope)

    def derivatives_are_off(self) -> float:
        """Return by how much CasADi's derivatives differ from quotients, relative to the largest."""
        worst = 0.0
        for k in range(0, len(self.signals.x), max(len(self.signals.x) // 7, 1)):
            at = np.concatenate([self.values, self.states[k], self.signals.x[k : k + 1]])
            exact = np.array(
                self.slopes(self.values, self.states[k], at[-1], self.signals.around[:, k])
            )
            found = np.empty_like(exact)
            for j, value in enumerate(at):
                h = 1e-6 * max(abs(value), 1e-9 if j >= len(self.values) else 1e-6)
                ahead, behind = (self._outputs(at, j, value + sign * h, k) for sign in (1, -1))
                found[:, j] = (ahead - behind) / (2 * h)
            scale = np.maximum(np.abs(exact).max(axis=0), 1e-12)
            # next to a corner a quotient says nothing
            off = np.abs(exact - found).max(axis=0) / scale
            worst = max(worst, float(np.median(off)))
        return worst

    def _outputs(self, at: np.ndarray, j: int, value: float, k: int) -> np.ndarray:
        moved = at.copy()
        moved[j] = value
        count = len(self.values)
        out = self.step(moved[:count], moved[count:-1], moved[-1], self.signals.around[:, k])[3]
        return np.array(out).ravel()


def _over(effect: OwnEffect, signals: Signals) -> Iterator[Finding]:
    span = np.ptp(signals.x)
    for own in _guesses(effect):
        run = _Run(effect, own, signals)
        at = ", ".join(f"{p.name} {own[f'{effect.name}.{p.name}']:g}" for p in effect.parameters)
        where = f"{signals.name}, {at}"
        finite = bool(np.all(np.isfinite(run.y)))
        most = np.abs(run.y - signals.x).max() / span if finite else np.nan
        yield Finding(
            f"finite over {where}",
            f"changes its input by up to {100 * most:.3g} % of the range" if finite else "not finite",
            finite,
        )
        if effect.has_inverse and finite:
            low, high = run.slope.min(), run.slope.max()
            yield Finding(
                f"monotone over {where}", f"the output's slope is {low:.4g} to {high:.4g}", low > 0.0
            )
            if low > 0.0:
                off = _inverse_is_off(effect, run) / span
                yield Finding(f"inverse over {where}", f"off by {off:.1g} of the range", off < 1e-9)
        off = run.derivatives_are_off() if finite else np.nan
        yield Finding(f"derivatives over {where}", f"quotients differ by {off:.1g}", off < _QUOTIENT)


def _inverse_is_off(effect: OwnEffect, run: _Run) -> float:
    """Return the largest error of the input that the inverse gives, of some samples."""
    symbols, state, _, around = symbols_of(effect)
    x = run.signals.x
    ends = dict(zip(ENDS[effect.side], (x.min(), x.max()), strict=True))
    y = ca.SX.sym("y")
    back = effect.inverse({**symbols, **ends}, list(state), y, around)[0]
    inputs = [ca.vertcat(*symbols.values()), ca.vertcat(*state), y, ca.vertcat(*around)]
    inverse = ca.Function("inverse", inputs, [back])
    places = range(0, len(x), max(len(x) // 50, 1))
    return max(
        abs(float(inverse(run.values, run.states[k], run.y[k], run.signals.around[:, k])) - x[k])
        for k in places
    )


def _in_chain(effect: OwnEffect) -> Iterator[Finding]:
    """Yield what is found in the paper's stage with the effect."""
    own = {n: v for n, v in _guesses(effect)[0].items() if n.startswith(f"{effect.name}.")}
    try:
        parameters = ParameterSet({**table_1(), **own}, effect.name).validate()
    except InputError as error:
        raise InputError(f"{effect.file}:{line_of(effect)}: {error}") from None
    voltage = 52.5 - 52.5 * np.cos(0.025 * np.arange(_TIMED))
    ours = compiled.chain_free_run(parameters, voltage[:_TICKS])[1]
    theirs = Chain(parameters).free_run(voltage[:_TICKS])[1]
    off = np.abs(ours - theirs).max() / np.abs(theirs).max()
    yield Finding("C and CasADi", f"Table 1 with it differs by {off:.1g}", off < _SAME)
    with_it, without = (_time_of_a_tick(p, voltage) for p in (parameters, table_1()))
    yield Finding(
        "time",
        f"{1e9 * with_it:.0f} ns for a tick of Table 1 with it, {1e9 * without:.0f} without",
        True,
    )


def _time_of_a_tick(parameters: ParameterSet, voltage: np.ndarray) -> float:
    taken = []
    for _ in range(5):
        begin = time.perf_counter()
        compiled.chain_free_run(parameters, voltage)
        taken.append(time.perf_counter() - begin)
    return min(taken) / len(voltage)
