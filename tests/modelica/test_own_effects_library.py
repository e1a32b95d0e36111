"""The Modelica library with effects of the user's own: its record has them, and its C computes them."""

import subprocess

import numpy as np
import pytest
from casadi_runs import assert_same
from effects import signals, surroundings
from library import PLANT, model
from own_effects import NAMES, in_chain, with_own
from test_glue import FLAGS, HOST, c_call, external_functions, new, outputs, talk, tick
from test_simulation import rumoca, run_from

from it2hys.export.modelica import field
from it2hys.export.modelica_release import write_release
from it2hys.fmu.own_library import compiler
from it2hys.model import compiled

SAMPLES = 300


def test_the_modelica_library_computes_it(tmp_path):
    """Its record has the parameters, and what its blocks call is the C chain."""
    with in_chain(*NAMES) as effects:
        write_release(tmp_path)
        (library,) = tmp_path.glob("IT2Hysteresis*")
        base = (library / "Parameters" / "Base.mo").read_text(encoding="utf-8")
        for effect in effects:
            for p in effect.parameters:
                assert f" {effect.name}{p.name[0].upper()}{p.name[1:]}(" in base
        calls = [c_call(name, clause) for name, clause in external_functions()]
        (tmp_path / "external.h").write_text("\n\n".join([*calls, ""]))
        folders = [library / "Resources" / "C-Sources", HOST, tmp_path]
        command = [*compiler(), *FLAGS, *(f"-I{folder}" for folder in folders)]
        host = tmp_path / "host"
        subprocess.run([*command, str(HOST / "glue_host.c"), "-o", str(host), "-lm"], check=True)
        parameters, voltage = with_own(effects), signals(SAMPLES, 20.0, 90.0)
        force, temperature = surroundings(SAMPLES)
        ticks = [tick(0, k, voltage[k], force[k], temperature[k]) for k in range(SAMPLES)]
        answers = talk(host, new(0, "plant", parameters), *ticks, "free 0")
        got = outputs([a for a in answers if not a.startswith("warning")])
        expected = compiled.chain_free_run(parameters, voltage, force, temperature)
        assert_same(got[:, 0], expected[0])
        assert_same(got[:, 1], expected[1])


@pytest.mark.parametrize("switched", [0.0, 0.02])
def test_pure_modelica_refuses_it_by_name(tmp_path, switched):
    """It would be left out in silence: the blocks in pure Modelica call no C."""
    with in_chain("gain") as (effect,):
        write_release(tmp_path)
        name = field(effect.switch)
    source = model(
        f"{PLANT} plant(parameters({name}={switched}), initialDisplacement=2e-6);",
        "plant.voltage = 10;",
    )
    if not switched:
        assert np.isfinite(run_from(tmp_path, source, "plant.displacement")).all()
        return
    with pytest.raises(rumoca.SimulationError) as caught:
        run_from(tmp_path, source, "plant.displacement")
    said = str(caught.value)
    assert (
        "M.plant: the effect gain is on, which pure Modelica does not have; take IT2Hysteresis.Blocks"
        in said
    )
    assert f"or set {name} to 0." in said
