"""The values of all cases of a sweep, drawn from its seed alone."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping

import numpy as np
import scipy

from it2hys.errors import InputError
from it2hys.sweeps.plan import LARGEST_CASES
from it2hys.sweeps.schema import SweepScenario, Vary


def draw(scenario: SweepScenario) -> np.ndarray:
    """Return the value of every axis in every case of one variant, shape (cases, axes).

    Grid axes are crossed with each other, with the rows of the list axes, and with the samples; the
    last varies fastest.
    """
    groups = {m: [i for i, v in enumerate(scenario.vary) if v.method == m] for m in
              ("grid", "list", "random", "latin hypercube")}  # fmt: skip
    _check_count(scenario, groups)
    blocks: list[tuple[list[int], np.ndarray]] = []
    for i in groups["grid"]:
        blocks.append(([i], _grid(scenario.vary[i])[:, None]))
    if groups["list"]:
        columns = [_grid(scenario.vary[i]) for i in groups["list"]]
        lengths = {len(c) for c in columns}
        if len(lengths) > 1:
            raise InputError(
                f"vary: lists that go together have {sorted(lengths)} values; they must have as many"
            )
        blocks.append((groups["list"], np.column_stack(columns)))
    drawn = [*groups["random"], *groups["latin hypercube"]]
    if drawn:
        blocks.append((drawn, _samples(scenario, groups)))
    count = math.prod(len(block) for _, block in blocks)
    matrix = np.empty((count, len(scenario.vary)))
    rest = count
    for places, block in blocks:
        rest //= len(block)
        matrix[:, places] = block[np.arange(count) // rest % len(block)]
    return matrix


def _check_count(scenario: SweepScenario, groups: Mapping[str, list[int]]) -> None:
    """Refuse more cases than can be run, before there are any."""
    factors = {f"{v.place}{_told(v)}": _size(v) for v in (scenario.vary[i] for i in groups["grid"])}
    if groups["list"]:
        vary = scenario.vary[groups["list"][0]]
        factors[f"{vary.place}{_told(vary)}"] = _size(vary)
    if groups["random"] or groups["latin hypercube"]:
        factors[f"samples = {scenario.samples}"] = scenario.samples
    if len(scenario.variants) > 1:
        factors[f"{len(scenario.variants)} variants"] = len(scenario.variants)
    cases = math.prod(factors.values())
    if cases > LARGEST_CASES:
        needed = 8e-9 * cases * (len(scenario.vary) + len(scenario.metrics))
        raise InputError(
            f"{' × '.join(factors)}: {cases:.3g} cases, whose table needs {needed:.3g} GB; at most "
            f"{LARGEST_CASES:,} can be run, so lower {'one of these' if len(factors) > 1 else 'it'}"
        )


def _size(vary: Vary) -> int:
    """Return the number of values of a grid or of a list."""
    return len(vary.values) or vary.count


def _told(vary: Vary) -> str:
    return f"{len(vary.values)} values" if vary.values else f"count = {vary.count}"


def _grid(vary: Vary) -> np.ndarray:
    if vary.values:
        return np.array(vary.values)
    space = np.geomspace if vary.scale == "log" else np.linspace
    return space(*vary.range, vary.count)


def _samples(scenario: SweepScenario, groups: Mapping[str, list[int]]) -> np.ndarray:
    """Return samples of the drawn axes, the random ones before the Latin hypercube's."""
    count, columns = scenario.samples, []
    for i in groups["random"]:
        # every axis has a stream of its own: another axis does not change its draws
        name = int.from_bytes(hashlib.sha256(scenario.vary[i].name.encode()).digest()[:8])
        uniform = np.random.default_rng([scenario.seed, name]).random(count)
        columns.append(_quantile(scenario.vary[i], uniform))
    hypercube = groups["latin hypercube"]
    if hypercube:
        sampler = scipy.stats.qmc.LatinHypercube(
            len(hypercube), rng=np.random.default_rng(scenario.seed)
        )
        for i, uniform in zip(hypercube, sampler.random(count).T, strict=True):
            columns.append(_quantile(scenario.vary[i], uniform))
    return np.column_stack(columns)


def _quantile(vary: Vary, uniform: np.ndarray) -> np.ndarray:
    if vary.values:
        index = np.minimum((uniform * len(vary.values)).astype(int), len(vary.values) - 1)
        return np.array(vary.values)[index]
    if vary.normal:
        return vary.normal[0] + vary.normal[1] * scipy.special.ndtri(np.clip(uniform, 1e-12, 1 - 1e-12))
    low, high = vary.range
    return low * (high / low) ** uniform if vary.scale == "log" else low + (high - low) * uniform
