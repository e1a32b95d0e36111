"""Components and examples, simulated in rumoca against what their equations say."""

from functools import cache

import numpy as np
import pytest
from compared import HEAD, PACKAGE, model_of, package
from effects import with_effects
from library import EXAMPLES as EXAMPLED
from library import PREAMBLE, comparison_signals, differences, experiment, model, stored_result
from scipy.linalg import expm
from test_simulation import compile_model, relative, rumoca, run
from units import faults

from it2hys.cli import main
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet, read_ssv, table_1, write_ssv

COMPONENTS = "IT2Hysteresis.Components"
EXAMPLES = "IT2Hysteresis.Examples"
CIRCUIT = (
    f"Modelica.Electrical.Analog.Basic.Ground ground; {COMPONENTS}.VoltageAmplifier amplifier(k=1); "
    f"{COMPONENTS}.PiezoActuator actuator(v(start=0, fixed=true), {{changes}}); "
    "Modelica.Mechanics.Translational.Components.Fixed base;"
)
WIRES = (
    "connect(amplifier.p, actuator.p); connect(amplifier.n, actuator.n); "
    "connect(amplifier.n, ground.p); connect(base.flange, actuator.flange_a);"
)
BLOCKED = "Modelica.Mechanics.Translational.Components.Fixed tip(s0=actuator.length);"
FRAMES = "".join(
    f"Modelica.Mechanics.Translational.Components.Fixed {name}(s0={s0}); "
    for name, s0 in (("a", 0), ("b", 18e-3))
)
HELD = "connect(tip.flange, actuator.flange_b);"
FREE = ""  # a flange that nothing is connected to has no force
AT_REST = "s_rel(fixed=true), v_rel(fixed=true), zeta=0.7"


def circuit(drive: str, mechanics: str, changes: str = "zeta=0.05", more: str = "") -> str:
    """Return a model of an amplifier and an actuator."""
    equations = f"amplifier.u = {drive}; {WIRES} {mechanics}"
    return model(CIRCUIT.format(changes=changes) + more, equations)


@cache
def simulate(example: str, package: str = "IT2HysteresisTest") -> "rumoca.Result":
    """Simulate an example with its own experiment; in the test package, it compares itself."""
    stop, interval = experiment(f"{EXAMPLES}.{example}")
    compiled_model = compile_model(f"model M {PREAMBLE} extends {package}.{example}; end M;")
    assert compiled_model.structure().is_balanced
    assert not faults(compiled_model.to_dict("flat")), "units do not fit"
    return compiled_model.simulate(
        t=(0.0, stop), dt=interval, config=rumoca.SimConfig(solver="rk-like")
    )


def started_at(voltage: float) -> ParameterSet:
    """Return Table 1, at rest at a voltage."""
    at_rest = compiled.chain_free_run(table_1(), np.full(4000, voltage))[0][-1]
    return table_1().replace(initialDisplacement=float(at_rest))


# --- actuator and amplifier ------------------------------------------------------------------------


def test_the_blocked_actuator_pushes_with_its_stiffness_times_the_free_stroke():
    at = run(
        circuit("40 - 40*cos(300*time)", HELD, more=BLOCKED + "Real most = actuator.blockedForce;"), 150
    )
    free, _ = compiled.chain_free_run(started_at(0.0), at("actuator.v"))
    assert relative(at("actuator.f"), 2e7 * free) < 1e-9
    assert at("actuator.s_rel") == pytest.approx(0.0, abs=1e-18)
    assert relative(at("tip.flange.f"), at("actuator.f")) < 1e-9
    assert at("actuator.q") == pytest.approx(1.5e-6 * at("actuator.v"), rel=1e-12)
    assert at("most")[0] == pytest.approx(320.0)


def test_the_free_actuator_settles_at_its_free_stroke_and_has_drawn_its_charge():
    at = run(circuit("min(60, 6e3*time)", FREE, AT_REST), 800)
    free, _ = compiled.chain_free_run(started_at(0.0), at("actuator.v"))
    assert at("actuator.s_rel")[-1] == pytest.approx(free[-1], rel=1e-4)
    alpha = 2e7 * 16e-6 / 110.0
    charge = 1.5e-6 * at("actuator.v") + alpha * at("actuator.s_rel")
    assert at("actuator.q") == pytest.approx(charge, rel=1e-9)


def test_the_charge_is_the_integral_of_the_current():
    at = run(circuit("min(60, 6e3*time)", FREE, AT_REST, "Real drawn(start=0, fixed=true);")
             .replace("equation", "equation der(drawn) = actuator.i;", 1), 400)  # fmt: skip
    assert at("drawn") == pytest.approx(at("actuator.q") - at("actuator.q")[0], rel=1e-3, abs=1e-8)


def test_the_current_limit_makes_a_slew_limit():
    at = run(circuit("100", HELD, "zeta=0.05", BLOCKED + "Real i = amplifier.i;"), 12)
    assert at("i")[2] == pytest.approx(0.3)
    slew = np.diff(at("actuator.v"))[2:4] / 1e-4
    assert slew == pytest.approx(0.3 / 1.5e-6, rel=1e-6)


def test_the_amplifier_keeps_to_its_voltages():
    at = run(circuit("200*sin(700*time)", HELD, "zeta=0.05", BLOCKED), 100)
    voltage = at("actuator.v")
    assert voltage.max() == pytest.approx(150.0, rel=1e-6)
    assert voltage.min() > -1e-3


def test_the_guide_takes_its_part_of_the_stroke_and_moves_the_platform_by_the_lever():
    parts = f"{COMPONENTS}.FlexureGuide guide(ratio=-2, c=5e6);"
    at = run(
        circuit("min(60, 6e3*time)", "connect(actuator.flange_b, guide.flange_a);", AT_REST, parts), 800
    )
    free = compiled.chain_free_run(started_at(0.0), at("actuator.v"))[0]
    start = started_at(0.0)["initialDisplacement"]
    # in series with the stack's 20 N/um; the guide is as mounted where the run begins
    expected = start + (free[-1] - start) * 20.0 / 25.0
    assert at("actuator.s_rel")[-1] == pytest.approx(expected, rel=1e-3)
    moved = at("guide.flange_b.s") - at("guide.flange_b.s")[0]
    assert moved == pytest.approx(
        -2 * (at("actuator.s_rel") - at("actuator.s_rel")[0]), rel=1e-6, abs=1e-12
    )
    assert at("guide.stackForce")[-1] == pytest.approx(200.0 + 5e6 * at("guide.x")[-1], rel=1e-3)


def test_energy_goes_into_the_stack_the_flanges_or_the_heat_port():
    """What the pins give is the change of both stored energies, the work at the flanges, the loss."""
    more = " ".join(f"Real {name}(start=0, fixed=true);" for name in ("given", "lost", "worked"))
    source = circuit("40 - 40*cos(600*time)", FREE, AT_REST + ", G=1e-5, c=2e7", more)
    rates = (
        "equation der(given) = actuator.v*actuator.i; der(lost) = actuator.LossPower; "
        "der(worked) = actuator.f*actuator.v_rel;"
    )
    at = run(source.replace("equation", rates, 1), 600)
    stored = 0.5 * 1.5e-6 * at("actuator.v") ** 2 + 0.5 * 2e7 * at("actuator.s_rel") ** 2
    balance = at("given") - at("lost") - at("worked")
    assert balance == pytest.approx(stored - stored[0], abs=2e-3 * np.ptp(stored))
    periods = at("lost")[[0, 105, 210, 314, 419, 524]]
    assert (np.diff(periods)[1:] > 0).all(), "a loop takes energy, period by period"


def test_the_charge_amplifier_gives_the_charge_and_keeps_to_its_voltages():
    declarations = CIRCUIT.replace("VoltageAmplifier amplifier(k=1)", "ChargeAmplifier amplifier")
    equations = f"amplifier.u = if time < 0.02 then 250*time else 20; {WIRES}"
    at = run(model(declarations.format(changes=AT_REST), equations), 500)
    drawn = at("actuator.q") - at("actuator.q")[0]
    early = np.arange(500) < 190
    assert drawn[early] == pytest.approx(2e-5 * 250 * 1e-4 * np.arange(500)[early], abs=4e-6)
    assert at("actuator.v").max() < 152.0


def test_the_actuators_drift_follows_the_temperature_of_its_heat_port():
    stage = "T=303.15, stage(driftTemperatureCoefficient=5e-8)"
    warm = run(circuit("0", FREE, f"{AT_REST}, {stage}"), 40)
    cold = run(circuit("0", FREE, AT_REST), 40)
    assert warm("actuator.s_rel") - cold("actuator.s_rel") == pytest.approx(10 * 5e-8, rel=1e-3)


@pytest.mark.parametrize("component", ["SampledPI", "StrainGauge"])
def test_the_sample_time_is_that_of_the_parameter_set(component):
    source = model(
        f"parameter IT2Hysteresis.Parameters.Table1 stage(sampleTime=2.5e-4); "
        f"{COMPONENTS}.{component} part(parameters=stage); Real Ts = part.sampleTime; "
        + ("" if component == "SampledPI" else FRAMES),
        {"SampledPI": "part.reference = 1e-6; part.measured = 0;"}.get(
            component, "connect(a.flange, part.flange_a); connect(b.flange, part.flange_b);"
        ),
    )
    assert run(source, 4, 2.5e-4)("Ts")[-1] == 2.5e-4


# --- gauge and controller ----------------------------------------------------------------------------


def gauge(parameters: str, ticks: int = 600):
    """Simulate a gauge between two points; returns reading and distance at the ticks."""
    mover = (
        "model Mover Modelica.Mechanics.Translational.Interfaces.Flange_b flange; Real s; "
        "equation flange.s = s; end Mover; "
    )
    source = mover + model(
        f"{COMPONENTS}.StrainGauge gauge(offset=1e-3{parameters}); Real distance; "
        "Modelica.Mechanics.Translational.Components.Fixed base(s0=0.5); "
        "Mover mover;",
        "distance = 8e-6 + 9e-6*sin(120*time); mover.s = 0.501 + distance; "
        "connect(base.flange, gauge.flange_a); connect(mover.flange, gauge.flange_b);",
    )
    at = run(source, ticks)
    return at("gauge.y"), at("distance")


def test_the_gauge_reads_in_steps_and_within_its_range():
    reading, distance = gauge(", bits=6, sigma=0")
    quantum = 16e-6 / 63
    assert np.rint(reading / quantum) * quantum == pytest.approx(reading, abs=1e-15)
    assert np.abs(reading - np.clip(distance, 0, 16e-6)).max() <= quantum / 2 + 1e-12
    assert reading.max() == pytest.approx(16e-6) and reading.min() == 0.0


def test_the_gauges_noise_has_its_deviation_and_its_seed():
    reading, distance = gauge(", yMin=-1e-5, yMax=3e-5, sigma=5e-8, bits=24")
    noise = reading - distance
    assert 0.7 * 5e-8 < noise.std() < 1.3 * 5e-8
    assert abs(noise.mean()) < 1e-8
    other, _ = gauge(", yMin=-1e-5, yMax=3e-5, sigma=5e-8, bits=24, seed=7")
    assert not np.array_equal(other, reading)


def test_the_controller_is_its_equations_with_the_error_of_the_tick_before():
    source = model(
        f"{COMPONENTS}.SampledPI pi(k=3e6, Ti=4e-4, yMax=20);",
        "pi.reference = 5e-6*sin(300*time); pi.measured = 3e-6*sin(500*time);",
    )
    at = run(source, 200)
    error = np.concatenate([[0.0], (at("pi.reference") - at("pi.measured"))[:-1]])
    integral, expected = 0.0, []
    for e in error:
        integral = np.clip(integral + 3e6 * 1e-4 / 4e-4 * e, -20.0, 20.0)
        expected.append(np.clip(3e6 * e + integral, -20.0, 20.0))
    assert np.abs(expected).max() == 20.0
    assert at("pi.y") == pytest.approx(np.array(expected), abs=1e-9)


# --- examples ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", EXAMPLED)
def test_an_example_gives_its_stored_result_and_stays_in_range(name):
    """At the interval that it is stored with: what its text says must be in it."""
    result = simulate(name.rsplit(".", 1)[-1])
    listed = comparison_signals(name)
    assert sorted(stored_result(name)[1]) == sorted(listed)
    assert not differences(name, np.asarray(result.time), lambda n: np.asarray(result[n]))
    ranges = [n for n in result.names if n.endswith((".left", ".short"))]
    assert not any(np.asarray(result[n]).any() for n in ranges)


def test_the_test_package_is_that_of_the_stored_results():
    assert PACKAGE.read_text(encoding="utf-8") == package(), "run compared.py"


def test_an_example_that_is_away_from_its_stored_result_stops():
    away = model_of(f"{EXAMPLES}.HysteresisLoop").replace("tolerance=", "tolerance=1e-9*")
    within = f"package P {PREAMBLE} {HEAD.split(';', 1)[1]} {away} end P;"
    source = f"{within} model M extends P.HysteresisLoop; end M;"
    with pytest.raises(rumoca.SimulationError, match=r"M\.compared\d: the signal is away"):
        run(source, 600)


def current_of_the_stage(ticks: int, points: int) -> np.ndarray:
    """Return the current of FlexureStage, A, without Modelica: exact steps of its linear equations.

    Between ticks the free stroke is constant. The amplifier's limits are not reached.
    """
    resistance, lag, capacitance = 10.0, 2e-5, 1.5e-6
    stack, tip, charge = 2e7, 5e-3, 2e7 * 16e-6 / 110.0  # stiffness, mass, force per voltage
    flexure, spring, platform = (5e7, 300.0), (2e6, 50.0), 0.2
    damping, omega = 2 * 0.6 * np.sqrt(stack * tip), 2 * np.pi * 25.0
    rate, names = {}, ["source", "v", "s", "vs", "x", "vx", "one", "stroke", "cosine", "sine"]
    rate["source"] = {"source": -1 / lag, "one": 15 * 3.5 / lag, "cosine": -15 * 3.3 / lag}
    conductance = 1 / (resistance * capacitance)
    rate["v"] = {"source": conductance, "v": -conductance, "vs": -charge / capacitance}
    rate["s"], rate["x"] = {"vs": 1.0}, {"vx": 1.0}
    between = {"x": flexure[0], "s": -flexure[0], "vx": flexure[1], "vs": -flexure[1]}
    rate["vs"] = {n: k / tip for n, k in between.items()}
    rate["vs"]["stroke"] = stack / tip
    rate["vs"]["s"] -= stack / tip
    rate["vs"]["vs"] -= damping / tip
    rate["vx"] = {n: -k / platform for n, k in between.items()}
    rate["vx"]["x"] -= spring[0] / platform
    rate["vx"]["vx"] -= spring[1] / platform
    rate["cosine"], rate["sine"] = {"sine": -omega}, {"cosine": omega}
    matrix = np.array([[rate.get(row, {}).get(n, 0.0) for n in names] for row in names])
    step = expm(matrix * 1e-4 / points)
    start = float(started_at(3.0)["initialDisplacement"])
    state = np.array([3.0, 3.0, start, 0.0, start, 0.0, 1.0, start, 1.0, 0.0])
    current = []
    for _ in range(ticks):
        voltage, stroke = state[1], state[7]
        state[7] = compiled.one_step(table_1().rules, np.array([stroke]), float(voltage))[0]
        for _ in range(points):
            current.append((state[0] - state[1]) / resistance)
            state = step @ state
    return np.array(current)


def test_the_current_of_the_stage_has_the_ripple_of_the_sampled_stroke():
    """18.3 mA, computed without Modelica. Stored at the sample time it was 13.6 mA."""
    result, expected = simulate("FlexureStage"), current_of_the_stage(1200, 5)
    time, current = np.asarray(result.time), np.asarray(result["actuator.i"])
    late = time > 0.02
    assert current[late].max() == pytest.approx(expected[1000:].max(), rel=1e-3)
    assert current[late].min() == pytest.approx(expected[1000:].min(), rel=1e-3)
    assert current[late].max() == pytest.approx(18.3e-3, rel=5e-3)


def rms(values: np.ndarray) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def test_feedback_corrects_what_the_inverse_does_not_know():
    result = simulate("FeedforwardFeedback")
    assert rms(result["errorClosed.y"]) < 0.25 * rms(result["errorFeedforward.y"])


def test_feedback_brings_the_displacement_back_under_a_force():
    result = simulate("DisturbanceForce")
    error = np.abs(np.asarray(result["actuator.s_rel"]) - np.asarray(result["reference.y"]))
    time = np.asarray(result.time)
    taken = 40.0 / 2e7
    assert error[(time > 0.125) & (time < 0.127)].max() > 0.8 * taken
    assert error[(time > 0.165) & (time < 0.175)].max() < 0.2 * taken
    assert error[time < 0.125].max() < 0.1 * taken


def test_a_diagnosis_lowers_the_error_of_a_record_that_it_has_not_seen():
    """In its second period: what was before the record is not known."""
    result = simulate("MeasuredRecord")
    late = np.asarray(result.time) > 0.05
    assert rms(np.asarray(result["errorBefore.y"])[late]) == pytest.approx(0.31e-6, abs=0.01e-6)
    assert rms(np.asarray(result["errorAfter.y"])[late]) == pytest.approx(0.07e-6, abs=0.01e-6)


def test_the_spring_takes_its_part_of_the_stroke():
    at = simulate("FlexureStage")
    stack, platform = (np.asarray(at[n]) for n in ("actuator.s_rel", "platform.s"))
    moved = platform - 18e-3
    # flexure 50 N/um between, spring 2 N/um to the frame: in series
    assert moved.max() / stack.max() == pytest.approx(50.0 / 52.0, rel=0.01)


def test_an_exported_set_runs_in_an_example(tmp_path, capsys):
    parameters = with_effects(("play", "creep", "resonance"), seed=4, initialDisplacement=0.7e-6)
    ssv = tmp_path / "my stage.ssv"
    write_ssv(type(parameters)(dict(parameters), "my stage 2"), ssv)
    assert main(["package", str(ssv), "--modelica", "-o", str(tmp_path / "out")]) == 0
    record = tmp_path / "out" / "MyStage2.mo"
    assert str(record) in capsys.readouterr().out
    source = record.read_text(encoding="utf-8") + (
        f"model M {PREAMBLE} extends {EXAMPLES}.FeedforwardTracking("
        "redeclare record Stage = MyStage2); end M;"
    )
    at = run(source, 500)
    read = read_ssv(ssv)
    voltage, _ = compiled.chain_inverse_run(read, at("inverse.reference"))
    displacement, _ = compiled.chain_free_run(read, at("inverse.voltage"))
    assert relative(at("inverse.voltage"), voltage) < 1e-10
    assert relative(at("plant.displacement"), displacement) < 1e-10
