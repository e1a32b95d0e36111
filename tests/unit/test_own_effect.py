"""An effect of the user's own: what is refused, where it stands; C and CasADi are one model."""

import os
import subprocess
import sys
import time

import numpy as np
import pytest
import test_effects
from conftest import UM
from effects import gentle_reference, rough_reference, signals, surroundings, with_effects
from own_effects import NAMES, file_of, in_chain, with_own
from test_casadi_chain import assert_inverse_is_compiled, assert_plant_is_compiled
from test_chain_sensitivity import assert_derivatives_are_casadis, drive

from it2hys.errors import InputError
from it2hys.fmu import own_library
from it2hys.fmu.own_library import only_used, use_effects
from it2hys.fmu.own_template import template
from it2hys.model import compiled
from it2hys.model.chain import Chain
from it2hys.model.own_loading import load_effect
from it2hys.model.parameters import ParameterSet, table_1
from it2hys.model.stages import BEFORE_CORE, BEHIND_CORE, EFFECTS, READING, STAGES
from it2hys.model.variables import load_table

MOUNT = file_of("mount").read_text(encoding="utf-8")


# --- what is refused ---------------------------------------------------------------------------


def line_with(text: str, part: str) -> int:
    return next(i for i, line in enumerate(text.splitlines(), 1) if part in line)


#: What is replaced in mount.py by what, a part of the line that is named, and of the message.
REFUSED = {
    "not Python": ("states = 2", "states = = 2", "states = = 2", "invalid syntax"),
    "no effect": ("EFFECT = Mount()", "", '"""Second', "EFFECT must be an instance"),
    "raises at import": ("import math", "import mathx", "import mathx", "No module named 'mathx'"),
    "raises in step": ("2 * math.pi", "1 / 0 * math.pi", "1 / 0", "ZeroDivisionError"),
    "unknown parameter": ('"mount.frequency"', '"mount.freq"', "mount.freq", "values['mount.freq']"),
    "a branch": ("angle = 2", "angle = 1 if x > 0 else 2", "if x > 0", "casadi.if_else"),
    "fewer states": ("[u, state[0]]", "[u]", "def step", "returns 1 next states, and states is 2"),
    "one thing": (", [u, state[0]]", "", "def step", "must return two things"),
    "NaN": ("angle = 2", "angle = ca.sqrt(-1 - x * x) * 2", "def step", "not finite at x = 0"),
    "looks ahead": ("angle = 2", 'angle = ca.SX.sym("next") * 2', "def step", "depends on next"),
    "no inverse": ("return x + values", "return state[0] + 0 * values", "def step", "no inverse"),
    "a taken name": ('name = "mount"', 'name = "for"', "class Mount", "no word of C"),
    "no name": ('    name = "mount"\n', "", "class Mount", "a declaration is missing"),
    "a wrong side": ('"behind"', '"upon"', "class Mount", "side is 'upon'"),
    "a guess outside": ("guesses=(0.05,), d", "guesses=(5.0,), d", "class Mount", "must lie from"),
    "a limit": ("states = 2", "states, limits = 2, True", "class Mount", "cannot have limits"),
    "the voltage in the output": (" (u - x), ", " (u - around.voltage), ", "def step", "next states"),
    "the voltage in a short memory": ("[u, st", "[around.voltage, st", "class Mount", "Memory.LONG"),
    "states in the reading": ('"behind"', '"reading"', "class Mount", "cannot have states"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_a_stage_is_refused_with_file_and_line(case, tmp_path):
    old, new, place, said = REFUSED[case]
    assert old in MOUNT
    text, path = MOUNT.replace(old, new, 1), tmp_path / "mount.py"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        use_effects([path])
    message = str(refusal.value)
    assert message.startswith(f"{path}:{line_with(text, place)}: "), message
    assert said in message and "\n" not in message
    assert "mount" not in EFFECTS


def test_the_voltage_at_the_actuator_is_known_behind_the_core_alone(tmp_path):
    text = MOUNT.replace('"behind"', '"before"').replace("[u, st", "[around.voltage, st")
    (tmp_path / "mount.py").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r'mount.py:\d+: around.voltage is known "behind" the core'):
        load_effect(tmp_path / "mount.py")


MORE = {
    "inverse depends on around.voltage": "    def inverse(self, _, state, y, at):\n"
    "        return y + 0.1 * at.voltage, state",
    "inverse does not undo step": "    def inverse(self, _, state, y, __):\n        return y, state",
    "rest is not at rest": "    def rest(self, values, y):\n        return y, [y, 0.0]",
}


@pytest.mark.parametrize("said", MORE)
def test_an_inverse_or_a_rest_that_is_none_is_refused(said, tmp_path):
    text = MOUNT.replace("\n\nEFFECT", f"\n{MORE[said]}\n\n\nEFFECT")
    (tmp_path / "mount.py").write_text(text, encoding="utf-8")
    line = line_with(text, MORE[said].splitlines()[0])
    with pytest.raises(InputError, match=f"mount.py:{line}: {said}"):
        load_effect(tmp_path / "mount.py")


def test_a_name_is_given_once(tmp_path):
    (tmp_path / "other.py").write_text(MOUNT, encoding="utf-8")
    (tmp_path / "lag.py").write_text(MOUNT.replace("mount", "lag"), encoding="utf-8")
    for paths in ([file_of("mount"), tmp_path / "other.py"], [tmp_path / "lag.py"]):
        with pytest.raises(InputError, match=r":10: the name '(mount|lag)' is taken"):
            use_effects(paths)
        assert "mount" not in EFFECTS and not EFFECTS["lag"].__doc__.startswith("A share")


def test_parameters_that_have_no_inverse_are_refused(tmp_path):
    text = file_of("bend").read_text(encoding="utf-8").replace("high=0.8", "high=1.5")
    (tmp_path / "bend.py").write_text(text, encoding="utf-8")
    try:
        use_effects([tmp_path / "bend.py"])
        with pytest.raises(InputError, match=r"bend.share = 1\.2, .* does not rise .* no inverse"):
            ParameterSet({**table_1(), "bend.share": 1.2, "bend.scale": 40.0}).validate()
    finally:
        use_effects(())


# --- where it stands ---------------------------------------------------------------------------


def test_it_comes_and_goes():
    before = dict(STAGES), list(load_table().variables), table_1()
    native = compiled.native_directory()
    with in_chain("mount", "bend", "beat", "charge"):
        assert list(BEFORE_CORE)[-3:] == ["play", "bend", "charge"]
        assert list(BEHIND_CORE)[-2:] == ["nonlinearity", "mount"]
        assert list(READING) == ["hum", "beat"]
        assert list(EFFECTS) == list(STAGES) == [*BEFORE_CORE, *BEHIND_CORE, *READING]
        rows = load_table().variables
        assert list(rows[: len(before[1])]) == before[1]
        assert [v.value_reference for v in rows] == list(range(len(rows)))
        assert rows[len(before[1])].name == "mount.gain" and rows[len(before[1])].start == 0.0
        assert compiled.native_directory() != native
    assert (dict(STAGES), list(load_table().variables), table_1()) == before
    assert compiled.native_directory() == native


def test_off_it_changes_no_bit():
    voltage, plain = signals(300, -5.0, 115.0), with_effects(("lag", "creep", "hum"), 1)
    expected = compiled.chain_free_run(plain, voltage)
    with in_chain(*NAMES):
        found = compiled.chain_free_run(ParameterSet(dict(plain)), voltage)
    assert found[0].tobytes() == expected[0].tobytes()
    assert found[1].tobytes() == expected[1].tobytes()


def test_a_set_without_it_is_written_without_it():
    with in_chain("mount", "bend") as (mount, _):
        parameters = with_own([mount])
        with only_used(parameters) as alone:
            assert "mount.gain" in alone and "bend.share" not in alone and "bend" not in EFFECTS
        assert "bend" in EFFECTS


def test_a_set_with_it_names_the_file_that_is_missing():
    with pytest.raises(
        InputError, match=r"'mount.gain'; if 'mount' is an effect of your own.*--effect"
    ):
        ParameterSet({**table_1(), "mount.gain": 0.1})


def test_another_process_finds_it():
    """As the processes do that share the fits: they are spawned, and inherit the environment."""
    script = (
        "from it2hys.model.chain import EFFECTS; from it2hys.model import compiled;"
        "from it2hys.model.parameters import ParameterSet, table_1; import numpy as np;"
        "p = ParameterSet({**table_1(), 'mount.gain': 0.3});"
        "print(list(EFFECTS), compiled.chain_free_run(p, np.full(50, 60.0))[0][-1].hex())"
    )
    with in_chain("mount"):
        parameters = ParameterSet({**table_1(), "mount.gain": 0.3})
        here = compiled.chain_free_run(parameters, np.full(50, 60.0))[0][-1]
        done = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, check=True
        )
        assert done.stdout == f"{list(EFFECTS)} {here.hex()}\n"
    assert "IT2HYS_OWN_EFFECTS" not in os.environ


# --- one model ---------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=[*((n,) for n in NAMES), NAMES], ids="+".join)
def effects(request):
    with in_chain(*request.param) as found:
        yield found


@pytest.mark.parametrize("guess", [0, 1, 4])
def test_plant_and_inverse_in_c_are_casadis(effects, guess):
    parameters = with_own(effects, guess)
    assert_plant_is_compiled(parameters)
    assert_inverse_is_compiled(parameters, gentle_reference(300))
    # beyond the range, and with steps that nothing follows: it clamps, is followed and comes back
    rough = rough_reference(np.random.default_rng(guess), 300)
    back = np.concatenate([rough, np.full(300, 7 * UM)])
    assert assert_inverse_is_compiled(parameters, back) > 0


def test_the_plant_follows_its_inverse(effects):
    parameters, reference = with_own(effects), gentle_reference(300)
    force, temperature = surroundings(300)
    voltage, saturated = compiled.chain_inverse_run(parameters, reference, force, temperature)
    followed = compiled.chain_free_run(parameters, voltage, force, temperature)[0]
    assert saturated.sum() == 0
    assert np.abs(followed - reference).max() < 1e-13 * 16 * UM or "gain" in EFFECTS
    np.testing.assert_allclose(followed, reference, rtol=1e-9)


def assert_every_derivative_is_casadis(effects, parameters=None):
    parameters = parameters or with_own(effects)
    chain, driven = Chain(parameters), drive(parameters)
    expected = assert_derivatives_are_casadis(chain, parameters, driven)
    for effect in effects:
        own = [chain.names.index(f"{effect.name}.{p.name}") for p in effect.parameters]
        assert (np.abs(expected[:, own]).max(axis=0) > 0.0).all(), effect.name


def test_every_derivative_is_casadis(effects):
    assert_every_derivative_is_casadis(effects)


def test_the_voltage_at_the_actuator_is_behind_all_that_stands_before_the_core():
    with in_chain("heat") as effects:
        own = {n: v for n, v in with_own(effects).items() if n.startswith("heat.")}
        parameters = with_effects(("delay", "slew", "saturation", "lag", "play"), 3, **own)
        assert_plant_is_compiled(parameters)
        assert_inverse_is_compiled(parameters, gentle_reference(300))
        rough = rough_reference(np.random.default_rng(2), 300)
        assert assert_inverse_is_compiled(parameters, rough) > 0
        assert_every_derivative_is_casadis(effects, parameters)


def assert_it_rests_where_it_begins(effects):
    parameters = with_own(effects)
    hold = compiled.chain_equilibrium(parameters)
    displacement, _ = compiled.chain_free_run(parameters, np.full(50, hold))
    np.testing.assert_allclose(displacement, parameters["initialDisplacement"], rtol=1e-9)


@pytest.mark.parametrize(
    "promise",
    [
        test_effects.test_each_effect_is_the_same_in_casadi_and_c_and_shows,
        test_effects.test_casadi_derives_by_every_parameter_of_an_effect,
        test_effects.test_starts_lie_within_their_bounds_and_make_a_usable_set,
    ],
    ids=lambda promise: promise.__name__.removeprefix("test_"),
)
def test_it_passes_what_the_projects_own_pass(promise):
    with in_chain("mount"):
        promise("mount")


def test_it_rests_where_it_begins(effects):
    assert_it_rests_where_it_begins(effects)


def test_one_without_a_part_in_the_inverse_is_left_out_of_it():
    """Beside others that have one: the inverse is that of the chain without it."""
    with in_chain("late", "charge", "mount") as effects:
        parameters = with_own(effects)
        assert_plant_is_compiled(parameters)
        assert_inverse_is_compiled(parameters, gentle_reference(300))
        assert_inverse_is_compiled(parameters, rough_reference(np.random.default_rng(1), 300))
        assert_every_derivative_is_casadis(effects)
        assert_it_rests_where_it_begins(effects)
        reference = gentle_reference(300)
        found = compiled.chain_inverse_run(parameters, reference)[0]
        without = compiled.chain_inverse_run(parameters.replace(**{"late.share": 0.0}), reference)[0]
        np.testing.assert_allclose(found, without, rtol=1e-9)


def test_every_operation_of_casadi_is_the_same_in_c():
    with in_chain("every") as effects:
        assert_plant_is_compiled(with_own(effects))


def test_where_nothing_makes_the_output_the_inverse_is_saturated(tmp_path):
    """A stage that saturates softly: it cannot get above what its tanh reaches."""
    text = file_of("bend").read_text(encoding="utf-8")
    text = text.replace('"before"', '"behind"').replace("low=20.0, high=200.0", "low=1e-6, high=1e-3")
    text = text.replace("guesses=(80.0,)", "guesses=(8e-6,)").replace("high=0.8", "high=0.9999")
    (tmp_path / "bend.py").write_text(text, encoding="utf-8")
    try:
        use_effects([tmp_path / "bend.py"])
        values = {**table_1(), "bend.share": 0.999, "bend.scale": 8e-6, "initialDisplacement": 4 * UM}
        parameters = ParameterSet(values).validate()
        reference = np.concatenate([np.linspace(4, 12, 200), np.full(400, 4.0)]) * UM
        voltage, saturated = compiled.chain_inverse_run(parameters, reference)
        assert np.isfinite(voltage).all()
        reached = compiled.chain_free_run(parameters, voltage)[0]
        assert saturated[reference > 8.1 * UM].all() and not saturated[:50].any()
        assert not saturated[-50:].any()
        assert np.abs(reached - reference)[~saturated].max() < 1e-9 * 16 * UM
    finally:
        use_effects(())


def test_beyond_the_range_a_stage_may_fall(tmp_path):
    """A polynomial that rises over the range is inverted there, whatever it does outside."""
    text = file_of("bend").read_text(encoding="utf-8")
    curve = "x - share * (x - 60) ** 3 / scale**2, []"
    text = text.replace("(1 - share) * x + share * scale * ca.tanh(x / scale), []", curve)
    assert curve in text
    (tmp_path / "bend.py").write_text(text, encoding="utf-8")
    try:
        use_effects([tmp_path / "bend.py"])
        values = {**table_1(), "bend.share": 0.2, "bend.scale": 60.0, "initialDisplacement": 5 * UM}
        parameters = ParameterSet(values).validate()
        assert_plant_is_compiled(parameters)
        reference = gentle_reference(300)
        assert assert_inverse_is_compiled(parameters, reference) == 0
        voltage, _ = compiled.chain_inverse_run(parameters, reference)
        followed = compiled.chain_free_run(parameters, voltage)[0]
        np.testing.assert_allclose(followed, reference, rtol=1e-9)
    finally:
        use_effects(())


def test_a_range_without_ends_has_an_inverse_too():
    """As in a search, which does not know the range yet."""
    with in_chain("bend") as effects:
        parameters, reference = with_own(effects), gentle_reference(200)
        ends = dict.fromkeys(("displacementMin", "voltageMin"), -np.inf)
        ends |= dict.fromkeys(("displacementMax", "voltageMax"), np.inf)
        within = compiled.chain_inverse_run(parameters, reference)[0]
        without = compiled.chain_inverse_run({**parameters, **ends}, reference)[0]
        np.testing.assert_allclose(without, within, rtol=1e-12)


# --- how it is built ---------------------------------------------------------------------------


def test_it_is_built_once(monkeypatch):
    with in_chain("mount"):
        first = compiled.native_directory()
    monkeypatch.setattr(own_library, "run_all", lambda commands: pytest.fail("it is compiled again"))
    with in_chain("mount"):
        assert compiled.native_directory() == first


def test_what_is_not_used_for_long_leaves_the_cache(tmp_path, monkeypatch):
    def build(work, *_):
        (work / "native").mkdir()
        (work / "native" / compiled.library_name()).touch()

    monkeypatch.setenv("IT2HYS_CACHE", str(tmp_path))
    monkeypatch.setattr(own_library, "_build", build)
    monkeypatch.setattr(own_library, "set_own_effects", lambda *_: None)
    folder, now = tmp_path / "effects", time.time()
    for i in range(
        own_library.KEPT + 5
    ):  # 0 was used last; the last six are days old, one of them half built
        place = folder / f"{'new-' if i == own_library.KEPT + 4 else ''}{i}"
        (place / "native").mkdir(parents=True)
        age = 60.0 * i if i < own_library.KEPT - 1 else 2 * own_library.DAY + i
        os.utime(place, (now - age, now - age))
    use_effects([file_of("mount")])
    left = {place.name for place in folder.iterdir()}
    (made,) = (name for name in left if not name.isdigit())
    assert left == {made, *map(str, range(own_library.KEPT - 1))}
    os.utime(folder / made, (0.0, 0.0))
    use_effects([file_of("mount")])  # used again, so not the next to go
    assert time.time() - (folder / made).stat().st_mtime < own_library.DAY


def test_generated_code_has_no_warnings_and_compiles_in_single_precision(tmp_path):
    with in_chain(*NAMES):
        embedded = compiled.native_directory() / "embedded"
        for flags in ([], ["-DIT2HYS_SINGLE", "-Wdouble-promotion", "-Wfloat-conversion"]):
            command = [
                *own_library.compiler(), "-std=c99", "-O1", "-Wall", "-Wextra", "-Wpedantic",
                "-Wconversion", "-Werror", *flags, "-c", str(embedded / "it2hys.c"),
                "-o", str(tmp_path / "it2hys.o"),
            ]  # fmt: skip
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr[-3000:]


def test_without_a_compiler_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr(own_library.shutil, "which", lambda name: None)
    monkeypatch.setattr(own_library.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="pip install ziglang"):
        own_library.compiler.__wrapped__()


def test_zig_alone_will_do(monkeypatch):
    pytest.importorskip("ziglang")
    monkeypatch.setattr(own_library, "compiler", own_library.zig)
    with in_chain("mount") as effects:
        assert_plant_is_compiled(with_own(effects))


# --- the template ------------------------------------------------------------------------------


def test_the_template_works_as_it_stands(tmp_path):
    path = tmp_path / "slow_part.py"
    path.write_text(template("slow_part"), encoding="utf-8")
    try:
        (effect,) = use_effects([path])
        assert effect.name == "slow_part" and effect.has_inverse
        assert_plant_is_compiled(with_own([effect]))
    finally:
        use_effects(())


def test_calls_of_the_compiled_chain_do_not_look_for_the_library_each_time(monkeypatch):
    """A fit makes hundreds of thousands; looking for a file at each costs it half of its time."""
    looked, place = [], compiled.packaged_native()
    monkeypatch.setattr(compiled, "packaged_native", lambda: looked.append(1) or place)
    compiled.use_native(None)
    for _ in range(20):
        compiled.chain_free_run(table_1(), np.zeros(3))
    assert len(looked) == 1
