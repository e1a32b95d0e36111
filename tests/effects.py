"""Random parameter sets with effects, for the tests of the chain."""

import numpy as np
from conftest import TS, UM
from hypothesis import strategies as st

from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import ParameterSet, table_1
from it2hys.model.stages import own_effects

#: Effects that lose nothing: the inverse undoes them. Hum leaves the displacement as it is.
INVERTIBLE = ("lag", "play", "load", "creep", "resonance", "drift", "nonlinearity", "hum")


def _play(rng: np.random.Generator) -> dict[str, float]:
    count = int(rng.integers(1, 17))
    thresholds = np.cumsum(rng.uniform(0.1, 6.0, count))
    weights = rng.uniform(-0.5, 0.5, count) / count
    values = {f"play[{j}].threshold": float(r) for j, r in enumerate(thresholds, start=1)}
    return values | {f"play[{j}].weight": float(w) for j, w in enumerate(weights, start=1)}


def _creep(rng: np.random.Generator) -> dict[str, float]:
    values = {}
    for i in range(1, int(rng.integers(1, 17)) + 1):
        values[f"creep[{i}].gain"] = rng.uniform(-0.01, 0.03)
        values[f"creep[{i}].timeConstant"] = 10 ** rng.uniform(-4.5, 2.0)
    return values


def _values(effect: str, rng: np.random.Generator) -> dict[str, float]:
    """Return random parameters of one effect that is on."""
    uniform = rng.uniform
    if own := own_effects().get(effect):  # of the user's own, near a guess
        return {f"{effect}.{p.name}": p.guesses[0] * uniform(0.8, 1.2) for p in own.parameters}
    return {
        "delay": lambda: {"delay.time": rng.choice([uniform(0.0, 64.0), rng.integers(1, 65)]) * TS},
        "slew": lambda: {"slew.rate": uniform(2e3, 2e4)},
        "saturation": lambda: {
            "saturation.minimum": uniform(0.0, 40.0), "saturation.maximum": uniform(70.0, 100.0),
        },
        "lag": lambda: {"lag.timeConstant": uniform(1e-5, 1e-3)},
        "play": lambda: {
            **_play(rng),
            "initialDemagnetisation": uniform(-40.0, 40.0), "initialExcursion": uniform(-30.0, 50.0),
        },
        "load": lambda: {"load.compliance": uniform(1e-9, 5e-8)},
        "creep": lambda: {
            **_creep(rng),
            "initialCreep": uniform(-1.0, 1.0) * UM, "initialCreepAge": 10 ** uniform(-4.0, 1.0),
        },
        "resonance": lambda: {
            "resonance.frequency": uniform(300.0, 4500.0), "resonance.damping": uniform(0.02, 0.9),
            "resonance.samplingZero": uniform(-0.6, 0.0),
        },
        "drift": lambda: {
            "drift.temperatureCoefficient": uniform(-2e-8, 2e-8), "drift.rate": uniform(-2e-6, 2e-6),
        },
        "nonlinearity": lambda: {
            f"nonlinearity.{name}": uniform(-0.3, 0.3) * UM
            for name in ("quadratic", "cubic", "quartic", "quintic", "sextic")
        },
        "hum": lambda: {
            "hum.amplitude": 0.02 * UM, "hum.frequency": uniform(10.0, 400.0), "hum.phase": uniform(),
        },
    }[effect]()  # fmt: skip


def with_effects(effects: tuple[str, ...], seed: int, **changes: float) -> ParameterSet:
    """Return Table 1 with effects of random parameters; the same for the same seed."""
    rng = np.random.default_rng(seed)
    values = {**table_1(), "initialDisplacement": 5 * UM, "displacementZero": 0.3 * UM}
    for effect in effects:
        values.update({name: float(v) for name, v in _values(effect, rng).items()})
    if {"delay", "resonance"} <= {*effects}:  # no inverse makes up for this one, either
        values["resonance.samplingDelay"] = rng.uniform(0.0, 2.0) * TS
    for group in ("play", "creep"):
        del values[f"{group}Count"]
    return ParameterSet({**values, **changes}, ", ".join(effects)).validate()


def effect_sets(effects: tuple[str, ...] = tuple(EFFECTS)) -> st.SearchStrategy[ParameterSet]:
    """Return a strategy for sets with one of the effects, some or all of them."""
    some = st.lists(st.sampled_from(effects), unique=True).map(
        lambda chosen: tuple(e for e in effects if e in chosen)
    )
    one = st.sampled_from([(e,) for e in effects])
    return st.builds(with_effects, one | some | st.just(effects), st.integers(0, 2**32 - 1))


def moved(parameters: ParameterSet, distance: float) -> ParameterSet:
    """Return the set for a sensor that reads `distance` more, in m."""
    names = ("initialDisplacement", "displacementMin", "displacementMax", "displacementZero")
    values = {name: parameters[name] + distance for name in names}
    for i in range(1, parameters.counts["rule"] + 1):
        values[f"rule[{i}].centre"] = parameters[f"rule[{i}].centre"] + distance
        own = distance * (1.0 - parameters[f"rule[{i}].q1"])
        values[f"rule[{i}].q3"] = parameters[f"rule[{i}].q3"] + own
    return parameters.replace(**values).validate()


def signals(samples: int, low: float, high: float) -> np.ndarray:
    """Return a signal with turning points at several levels, between two values."""
    t = np.arange(samples) * TS
    wave = 0.8 * np.sin(250.0 * t) + 0.2 * np.sin(1700.0 * t)
    return 0.5 * (low + high) + 0.5 * (high - low) * wave


def surroundings(samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Return force in N and temperature in K."""
    t = np.arange(samples) * TS
    return 10.0 * np.sin(190.0 * t), 293.0 + 5.0 * np.cos(80.0 * t)


def rough_reference(rng: np.random.Generator, samples: int) -> np.ndarray:
    """Return a reference in m with steps, in parts noisy, in parts out of the range 0 to 16 um."""
    steps = np.repeat(rng.uniform(-4 * UM, 20 * UM, samples // 100 + 1), 100)[:samples]
    noisy = np.repeat(rng.random(samples // 100 + 1) < 0.3, 100)[:samples]
    return steps + np.where(noisy, rng.normal(0.0, 0.1 * UM, samples), 0.0)


def gentle_reference(samples: int) -> np.ndarray:
    """Return a reference in m that begins at rest at 5 um: a jump would ask for too much voltage."""
    fade = 1.0 - np.exp(-0.01 * np.arange(samples) ** 2)
    return 5 * UM + fade * (signals(samples, 5 * UM, 9 * UM) - 5 * UM)
