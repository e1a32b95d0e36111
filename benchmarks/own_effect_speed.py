"""How long a fit takes with an effect of the user's own, beside one of the project's of like size.

Usage: python benchmarks/own_effect_speed.py [SAMPLES]

A fit spends its time in the chain over a record with derivatives by everything that is fitted
(`compiled.chain_sensitivity`): that is timed, with Table 1's rules and the parameters of the effect.
"""

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from conftest import UM
from effects import with_effects
from own_effects import in_chain, with_own

from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet

#: One of the user's own in tests/unit/own, and one of the project's that is about as large.
PAIRS = (
    ("mount", "resonance"),
    ("bend", "nonlinearity"),
    ("heat", "creep"),
    ("friction", "play"),
    ("charge", "lag"),
    ("beat", "hum"),
)
#: Elements of the project's effects that have any, as many as the other has states of that kind.
ELEMENTS = {"creep": 1, "play": 2}
REPEATED = 15


def time_of_a_tick(parameters: ParameterSet, names: list[str], samples: int) -> float:
    """Return the shortest time for a sample with derivatives, in s."""
    ticks = np.arange(samples)
    voltage = 52.5 - 40.0 * np.cos(0.025 * ticks) + 10.0 * np.sin(0.3 * ticks)
    drive, packed = compiled.Drive.of(voltage), compiled.pack_chain(parameters)
    taken = []
    for _ in range(REPEATED):
        begin = time.perf_counter()
        measured, _ = compiled.chain_sensitivity(packed, drive, names)
        taken.append(time.perf_counter() - begin)
    assert np.isfinite(measured).all()
    return min(taken) / samples


def cut(parameters: ParameterSet, effect: str) -> ParameterSet:
    """Return the set with as many elements of an effect as the other one of the pair has."""
    if effect not in ELEMENTS:
        return parameters
    kept = {n: v for n, v in parameters.items() if not n.startswith(f"{effect}[")}
    for i in range(1, ELEMENTS[effect] + 1):
        kept |= {n: v for n, v in parameters.items() if n.startswith(f"{effect}[{i}]")}
    return ParameterSet({**kept, f"{effect}Count": ELEMENTS[effect]})


def fitted(parameters: ParameterSet, effect: str) -> list[str]:
    own = [n for n in parameters if n.startswith((f"{effect}.", f"{effect}["))]
    return [*own, "initialDisplacement"]


def main() -> None:
    samples = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000
    print(f"{'own':10} {'ns':>6}   {'project':14} {'ns':>6}   ratio")
    for own, ours in PAIRS:
        with in_chain(own) as effects:
            first = with_own(effects, initialDisplacement=0.0 * UM)
            with_it = time_of_a_tick(first, fitted(first, own), samples)
        second = cut(with_effects((ours,), 3), ours)
        built_in = time_of_a_tick(second, fitted(second, ours), samples)
        first_half = f"{own:10} {1e9 * with_it:6.0f}   {ours:14} {1e9 * built_in:6.0f}"
        print(f"{first_half}   {with_it / built_in:5.2f}", flush=True)


if __name__ == "__main__":
    main()
