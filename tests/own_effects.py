"""Effects of the user's own for the tests: files in tests/unit/own, and sets with them."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from conftest import UM

from it2hys.fmu.own_library import use_effects
from it2hys.model.own_effect import OwnEffect, sample_values
from it2hys.model.parameters import ParameterSet, table_1
from it2hys.model.stages import own_effects

FOLDER = Path(__file__).parent / "unit" / "own"
# what is built for the tests goes with the build folder
os.environ.setdefault("IT2HYS_CACHE", str(FOLDER.parents[2] / "build" / "cache"))
#: One for each way to stand in the chain, to remember, to rest and to be inverted.
NAMES = ("bend", "charge", "mount", "friction", "heat", "gain", "beat")


def file_of(name: str) -> Path:
    return FOLDER / f"{name}.py"


@contextmanager
def in_chain(*names: str) -> Iterator[tuple[OwnEffect, ...]]:
    """Have effects of tests/unit/own in the chain, for a while."""
    before = [e.file for e in own_effects().values()]
    try:
        yield use_effects(map(file_of, names))
    finally:
        use_effects(before)


def with_own(effects: Sequence[OwnEffect], guess: int = 0, **changes: float) -> ParameterSet:
    """Return Table 1 with effects at one of their guesses."""
    values = {**table_1(), "initialDisplacement": 5 * UM, "displacementZero": 0.3 * UM}
    for effect in effects:
        own = sample_values(effect, 8, seed=1)[guess]
        values |= {n: v for n, v in own.items() if n.startswith(f"{effect.name}.")}
    return ParameterSet({**values, **changes}, "own").validate()
