"""The compiled chain's derivatives are those that CasADi derives from the model, stage by stage.

No difference quotients on either side: what is compared is exact but for rounding.
"""

import casadi as ca
import numpy as np
import pytest
from conftest import TS
from effects import surroundings, with_effects

from it2hys.model import compiled
from it2hys.model.chain import EFFECTS, Chain
from it2hys.model.parameters import ParameterSet

TICKS = 120
#: A delay of a whole number of ticks has a corner there; limits are such that the voltage meets them.
CHANGES = {
    "delay": {"delay.time": 5.3 * TS},
    "saturation": {"saturation.minimum": 33.0, "saturation.maximum": 42.0},
}
#: What no fit changes: they are of the FMU, or the core's range, which a fit does not know yet.
FIXED = {"sampleTime", "voltageMin", "voltageMax", "displacementMin", "displacementMax"}


def drive(parameters: ParameterSet) -> compiled.Drive:
    """Return a voltage with steps and noise about rest, within the core's range."""
    rng = np.random.default_rng(1)
    rest = compiled.chain_equilibrium(parameters)
    steps = np.repeat(rng.uniform(-6.0, 12.0, TICKS // 20), 20)
    return compiled.Drive(rest + steps + rng.uniform(-1.0, 1.0, TICKS), *surroundings(TICKS))


def by_casadi(chain: Chain, signals: compiled.Drive) -> tuple[np.ndarray, np.ndarray]:
    """Return readings and their derivatives by all Real parameters, carried on tick by tick."""
    p, state = ca.SX.sym("p", len(chain.names)), ca.SX.sym("state", chain.state_size)
    inputs = [ca.SX.sym(f"u{i}") for i in range(4)]
    following, _, measured = chain.step(p, state, *inputs)
    outputs = ca.vertcat(following, measured)
    step = ca.Function(
        "step", [p, state, *inputs], [outputs, ca.jacobian(outputs, state), ca.jacobian(outputs, p)]
    )
    rest = chain.rest(p)
    begin = ca.Function("begin", [p], [rest, ca.jacobian(rest, p)])
    values = chain.vector()
    now, by = (m.full() for m in begin(values))
    read, rows = np.empty(TICKS), np.empty((TICKS, len(values)))
    for k in range(TICKS):
        u = signals.voltage[k], signals.force[k], signals.temperature[k], k * TS
        both, by_state, by_p = (m.full() for m in step(values, now, *u))
        derivatives = by_state @ by + by_p
        now, by = both[:-1], derivatives[:-1]
        read[k], rows[k] = both[-1, 0], derivatives[-1]
    return read, rows


def assert_derivatives_are_casadis(
    chain: Chain, parameters: ParameterSet, signals: compiled.Drive
) -> np.ndarray:
    """Compare the compiled chain's reading and derivatives with CasADi's; return all of these."""
    read, expected = by_casadi(chain, signals)
    rules = [name for name in chain.names if name.startswith("rule[")]
    fitted = [n for n in chain.names if n not in rules and n not in FIXED]
    measured, by = compiled.chain_sensitivity(compiled.pack_chain(parameters), signals, fitted)
    np.testing.assert_allclose(measured, read, rtol=0, atol=1e-12 * np.abs(read).max())
    for name, column in zip([*rules, *fitted], by.T, strict=True):
        exact = expected[:, chain.names.index(name)]
        error = np.abs(column - exact).max()
        assert error <= 1e-10 * np.abs(exact).max(), (name, error, np.abs(exact).max())
    return expected


@pytest.mark.parametrize(
    "effects", [(), *((e,) for e in EFFECTS), tuple(EFFECTS)], ids=lambda e: "+".join(e) or "core"
)
def test_every_derivative_is_casadis(effects):
    changes = {name: v for effect in effects for name, v in CHANGES.get(effect, {}).items()}
    parameters = with_effects(effects, seed=3, **changes)
    chain, signals = Chain(parameters), drive(parameters)
    expected = assert_derivatives_are_casadis(chain, parameters, signals)
    for effect in effects:
        own = [k for k, n in enumerate(chain.names) if n.startswith((f"{effect}.", f"{effect}["))]
        assert np.abs(expected[:, own]).max() > 0.0, effect
