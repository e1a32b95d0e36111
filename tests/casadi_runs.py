"""Runs of the public CasADi chain, one tick after the other."""

import casadi as ca
import numpy as np
from conftest import TS
from effects import surroundings

SAMPLES = 300
NAMES = ["force", "temperature", "time"]


def run(function: ca.Function, state: ca.DM, **signals: np.ndarray) -> dict[str, np.ndarray]:
    """Return the outputs of a run of one tick after the other, (N,) each."""
    samples = len(next(iter(signals.values())))
    rows = {name: np.asarray(values)[None, :] for name, values in signals.items()}
    result = function.mapaccum(samples)(state=state, **rows)
    return {name: values.full()[0] for name, values in result.items() if name != "next_state"}


def around(samples: int = SAMPLES) -> dict[str, np.ndarray]:
    force, temperature = surroundings(samples)
    return {"force": force, "temperature": temperature, "time": np.arange(samples) * TS}


def assert_same(ours: np.ndarray, theirs: np.ndarray) -> None:
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.max(np.abs(theirs)))
