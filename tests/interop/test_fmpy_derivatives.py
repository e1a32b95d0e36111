"""Directional derivatives against differences of steps that are made again."""

import pytest
from conftest import (
    CALM,
    INPUT,
    MODELS,
    OUTPUT,
    TS,
    UM,
    Instance,
)


@pytest.mark.parametrize("which", MODELS)
@pytest.mark.parametrize("size", [0.5, 1.0, 5.0])
def test_directional_derivatives_are_those_of_the_last_step(models, which, size):
    """Against a central difference over the same step, made again from a saved state."""
    with Instance(models[which]) as instance:
        instance.initialize({"initialDisplacement": 4.5 * UM})
        if size < 1:  # a step without a tick: outputs do not depend on its input
            instance.step(0.0, 0.25 * TS)
            time = 0.25 * TS
        else:
            time = 0.0
        state = instance.fmu.getFMUstate()

        def after(value: float) -> float:
            instance.fmu.setFMUstate(state)
            instance.assign({INPUT[which]: value})
            instance.step(time, size * TS)
            return instance.get(OUTPUT[which])

        delta = 1e-4 * CALM[which]
        expected = (after(CALM[which] + delta) - after(CALM[which] - delta)) / (2 * delta)
        after(CALM[which])
        (derivative,) = instance.fmu.getDirectionalDerivative(
            instance.references([OUTPUT[which]]), instance.references([INPUT[which]]), [1.0]
        )
        assert derivative == pytest.approx(expected, rel=1e-6, abs=0)
        assert (derivative == 0) == (size < 1)


def test_in_initialization_mode_derivatives_are_those_by_the_parameters(inverse):
    names = ["initialDisplacement"]
    names += [n for n in inverse.unpacked.variables if n.startswith("rule[")]
    inverse.fmu.setupExperiment()
    inverse.assign({"initialDisplacement": 4.5 * UM})
    inverse.fmu.enterInitializationMode()
    for name in names:
        value = inverse.get(name)
        (derivative,) = inverse.fmu.getDirectionalDerivative(
            inverse.references(["voltage"]), inverse.references([name]), [1.0]
        )
        delta = 1e-5 * abs(value)
        read = []
        for sign in (1, -1):
            inverse.assign({name: value + sign * delta})
            read.append(inverse.get("voltage"))
        inverse.assign({name: value})
        expected = (read[0] - read[1]) / (2 * delta)
        assert derivative == pytest.approx(expected, rel=1e-4, abs=1e-3), name
