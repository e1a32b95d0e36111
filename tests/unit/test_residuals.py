"""What is left over by a model: whether it is more than noise, and which effect it looks like."""

import re
from dataclasses import replace

import numpy as np
import pytest
from diagnosis import simulator as sim
from diagnosis import voltages
from scipy.signal import lfilter

from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.residuals import left_over, ljung_box, short_pole
from it2hys.errors import InputError
from it2hys.model.chain import EFFECTS
from it2hys.records.clues import Clue, Clues, Extent
from it2hys.reports.figures import png, residual_views

TS = 1e-4
UM = 1e-6
NOISE = 0.006 * UM
GRID = sim.Grid(TS, 10, True)
KINDS = (
    voltages.two_sines, voltages.staircase, voltages.slow_sine, voltages.multisine, voltages.staircase,
)  # fmt: skip


class Scene:
    """Records of a known base: what a model that is right leaves over is noise."""

    def __init__(self, samples: int, kinds=KINDS, seed: int = 3) -> None:
        rng = np.random.default_rng(seed)
        t = np.arange(samples) * TS
        self.voltage = np.array([draw(rng, t, 105.0) for draw in kinds])
        self.force = 30.0 * (1.0 - np.cos(2.0 * np.pi * rng.uniform(5.0, 30.0, (len(kinds), 1)) * t))
        walk = np.cumsum(rng.standard_normal((len(kinds), samples)), axis=1)
        self.temperature = 293.15 + walk / np.max(np.abs(walk))
        self.around = sim.Surroundings(GRID, np.tile(t, (len(kinds), 1)), self.force, self.temperature)
        self.base = sim.Plant(sim.TABLE_1).run(self.voltage, self.around) * UM
        spans = {"force": self.force, "temperature": self.temperature}
        spans = {name: (float(x.min()), float(x.max())) for name, x in spans.items()}
        self.extent = Extent(
            TS,
            samples * TS,
            (float(self.voltage.min()), float(self.voltage.max())),
            (float(self.base.min()), float(self.base.max())),
            **spans,
        )

    def clues(self, residual: np.ndarray) -> Clues:
        """Return the clues of residuals, shape (R, N), in m."""
        used = np.ones(residual.shape[1], dtype=bool)
        used[:10] = False
        rows = zip(
            self.voltage, self.force, self.temperature, self.base + residual, residual, strict=True
        )
        return Clues(self.extent, [Clue(*row, used) for row in rows])

    def change(self, effect: sim.Effect, name: str) -> np.ndarray:
        """Return what an effect changes, in m."""
        return sim.Plant(sim.TABLE_1, {name: effect}).run(self.voltage, self.around) * UM - self.base

    def noise(self, rng: np.random.Generator, pole: float = 0.0) -> np.ndarray:
        """Return noise of one pole, of NOISE rms."""
        white = rng.standard_normal(self.voltage.shape)
        start = pole * rng.standard_normal((len(white), 1))
        return NOISE * lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], white, zi=start)[0]


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene(4000)


@pytest.fixture(scope="module")
def small() -> Scene:
    return Scene(1100, KINDS[:3])


PRESENT = {
    "play": sim.Play("exponential", 20.0, 0.6, 105.0),
    "creep": sim.Creep.logarithmic(0.06, 5e-3, 2.0),
    "resonance": sim.Resonance(700.0, 0.03),
    "lag": sim.Lag(500.0, 2e-6),
    "delay": sim.Delay(4.0 * TS),
    "slew": sim.Slew(8000.0),
    "saturation": sim.Saturation(-1e3, 92.0),
    "drift": sim.Drift(0.1),
    "load": sim.Load(200.0),
    "nonlinearity": sim.Nonlinearity(0.0, 15.0, (0.02, 0.1, 0.15)),
    "hum": sim.Hum(0.05, 50.0, 1),
}


# --- signatures ----------------------------------------------------------------------------------


@pytest.mark.parametrize("effect", EFFECTS)
def test_a_signature_is_seldom_sure_of_noise(small, effect):
    rng = np.random.default_rng(11)
    p_values = []
    for i in range(40):
        residual = small.noise(rng, 0.6 if i % 2 else 0.0)
        p_values.append(EVIDENCE[effect].signature(small.clues(residual)).p_value)
    assert np.mean(np.array(p_values) < 0.01) <= 0.04
    assert np.all((np.array(p_values) >= 0.0) & (np.array(p_values) <= 1.0))


@pytest.mark.parametrize("effect", EFFECTS)
def test_the_effect_that_is_there_has_the_strongest_signature(scene, effect):
    residual = scene.change(PRESENT[effect], effect) + scene.noise(np.random.default_rng(5))
    found = {name: evidence.signature(scene.clues(residual)) for name, evidence in EVIDENCE.items()}
    sure = {name: s for name, s in found.items() if s.p_value < 1e-4}
    assert max(sure, key=lambda name: sure[name].statistic) == effect, found
    assert sure[effect].statistic > 0.5


def number(text: str, unit: str) -> float:
    return float(text.split(f" {unit}")[0].split()[-1])


def test_signatures_state_the_values_that_were_put_in(scene):
    noise = scene.noise(np.random.default_rng(6))

    def text(effect: str) -> str:
        residual = scene.change(PRESENT[effect], effect) + noise
        return EVIDENCE[effect].signature(scene.clues(residual)).text

    assert number(text("delay"), "ms") == pytest.approx(0.4, abs=0.06)
    assert number(text("resonance"), "Hz") == pytest.approx(700.0, rel=0.08)
    assert number(text("hum"), "Hz") == pytest.approx(50.0, abs=0.2)
    assert number(text("hum"), "µm") == pytest.approx(0.05, rel=0.05)
    assert number(text("load"), "µm/N") == pytest.approx(1.0 / 200.0, rel=0.03)
    assert number(text("drift"), "µm/K") == pytest.approx(0.1, rel=0.03)
    assert number(text("saturation"), "V") == pytest.approx(92.0, abs=5.0)
    assert number(text("slew"), "V/s") == pytest.approx(8000.0, rel=0.3)


def test_without_its_channel_an_effect_has_no_signature(scene):
    clues = scene.clues(scene.noise(np.random.default_rng(1)))
    bare = Clues(replace(scene.extent, force=None, temperature=None), clues.records)
    assert EVIDENCE["load"].signature(bare) is None
    assert "time" in EVIDENCE["drift"].signature(bare).text


@pytest.mark.parametrize("effect", EFFECTS)
def test_records_that_are_too_short_have_no_signature(scene, effect):
    parts = [Clue(*(x[:40] for x in vars(c).values())) for c in scene.clues(scene.base).records]
    assert EVIDENCE[effect].signature(Clues(scene.extent, parts)) is None


@pytest.mark.parametrize("effect", EFFECTS)
@pytest.mark.filterwarnings("error")
def test_no_residual_at_all_is_no_evidence(small, effect):
    signature = EVIDENCE[effect].signature(small.clues(np.zeros_like(small.base)))
    assert signature.p_value > 0.05


# --- the verdict ---------------------------------------------------------------------------------


def verdict(scene: Scene, residual: np.ndarray, noise: float = NOISE):
    return left_over(scene.clues(residual), [noise] * len(residual))


@pytest.mark.parametrize("pole", [0.0, 0.3, 0.6])
def test_noise_is_noise(scene, pole):
    rng = np.random.default_rng(2)
    for _ in range(10):
        residual = scene.noise(rng, pole)
        # as fourth differences estimate it
        estimate = np.std(np.diff(residual, 4)) / np.sqrt(70.0)
        found = verdict(scene, residual, estimate)
        assert not found.significant, found
        assert found.size == pytest.approx(1.0, abs=0.1)
        # coloured noise is not told from a small misfit
        wanted = "indistinguishable from noise." if pole == 0.0 else "noise"
        assert wanted in found.sentences[0]


@pytest.mark.parametrize("step", [0.5, 2.0, 3.0])
def test_quantisation_is_noise(scene, step):
    reading = scene.base + scene.noise(np.random.default_rng(3))
    residual = step * NOISE * np.round(reading / (step * NOISE)) - scene.base
    assert not verdict(scene, residual, np.std(residual)).significant


def test_a_little_misfit_is_not_called_significant_nor_noise(scene):
    misfit = scene.change(PRESENT["play"], "play")
    misfit *= 0.6 * NOISE / np.sqrt(np.mean(misfit**2))
    found = verdict(scene, misfit + scene.noise(np.random.default_rng(4)))
    assert not found.significant
    assert re.search(
        r"coloured noise is in it, too \(p .*\), smaller than the noise", found.sentences[0]
    )


OUTSIDE = {
    "jumps": sim.Jumps(0.05, 10.0, 1),
    "whistle": sim.Whistle(0.05, 100.0, 900.0, 1),
    "slip": sim.Slip(0.02, 1),
    "bursts": sim.Bursts(0.1, 0.1, 1),
    "hidden heat": sim.HiddenHeat(0.02, 1),
    "wander": sim.Wander(0.1, 1),
    "stiction": sim.Stiction(300.0),
}


@pytest.mark.parametrize("name", [*OUTSIDE, *PRESENT])
@pytest.mark.filterwarnings("error")
def test_what_is_not_noise_is_found_and_described(scene, name):
    effect = {**OUTSIDE, **PRESENT}[name]
    found = verdict(scene, scene.change(effect, name) + scene.noise(np.random.default_rng(7)))
    assert found.significant, found
    assert found.size > 1.3
    assert len(found.sentences) == 5


def test_the_description_says_what_it_looks_like(scene):
    noise = scene.noise(np.random.default_rng(8))

    def described(effect: sim.Effect, name: str) -> str:
        return " ".join(verdict(scene, scene.change(effect, name) + noise).sentences)

    hum = described(PRESENT["hum"], "hum")
    assert "narrow band" in hum
    assert number(hum[hum.index("narrow band") :], "Hz") == pytest.approx(50.0, abs=2.0)
    assert "it is slow" in described(OUTSIDE["wander"], "wander")
    assert "jumps" in described(OUTSIDE["jumps"], "jumps")
    assert "its power varies" in described(OUTSIDE["bursts"], "bursts")
    assert "stronger at high voltage" in described(PRESENT["saturation"], "saturation")
    assert "correlated with the voltage's rate" in described(PRESENT["lag"], "lag")


def test_a_disturbance_of_one_record_is_found_and_located(scene):
    residual = scene.noise(np.random.default_rng(9))
    residual[2, 2000:2250] += 10.0 * NOISE * np.sin(np.arange(250))
    found = verdict(scene, residual)
    assert found.significant
    text = " ".join(found.sentences)
    assert "largest in record 3" in text
    begin, end = map(float, re.search(r"greatest from ([\d.]+) to ([\d.]+) s", text).groups())
    assert 0.195 <= begin <= 0.205 and 0.22 <= end <= 0.23  # to the length of a block


def test_ljung_box_is_uniform_on_white_noise_and_sees_colour():
    rng = np.random.default_rng(10)
    p_values = [ljung_box(rng.standard_normal(1000)) for _ in range(400)]
    assert 0.02 < np.mean(np.array(p_values) < 0.05) < 0.09
    assert ljung_box(lfilter([1.0], [1.0, -0.3], rng.standard_normal(1000))) < 1e-6


def test_the_pole_of_the_noise_is_seen_beneath_a_slow_residual():
    rng = np.random.default_rng(12)
    slow = 20.0 * np.sin(np.linspace(0.0, 20.0, 5000))
    for pole in (0.0, 0.3, 0.55):
        noise = lfilter([1.0], [1.0, -pole], rng.standard_normal(5000))
        assert short_pole(noise + slow) == pytest.approx(pole, abs=0.06)


def test_unused_samples_do_not_count(scene):
    residual = scene.noise(np.random.default_rng(13))
    residual[:, :10] = 1e3 * NOISE
    assert not verdict(scene, residual).significant


def test_a_record_that_is_too_short_is_refused(scene):
    clues = scene.clues(scene.noise(np.random.default_rng(15)))
    clues.records[1] = Clue(*(x[:40] for x in vars(clues.records[1]).values()))
    with pytest.raises(InputError, match="record 2 has 30 samples"):
        left_over(clues, [NOISE] * 5)


def test_a_line_that_the_voltage_has_is_no_hum(scene):
    t = np.arange(4000) * TS
    # at the second harmonic of a drive that is the same in every record
    drive = np.tile(50.0 * (1.0 - np.cos(2.0 * np.pi * 25.0 * t)), (5, 1))
    residual = 0.05 * UM * np.sin(2.0 * np.pi * 50.0 * t) + scene.noise(np.random.default_rng(16))
    clues = scene.clues(residual)
    same = Clues(
        clues.extent, [replace(c, voltage=v) for c, v in zip(clues.records, drive, strict=True)]
    )
    found = EVIDENCE["hum"].signature(same)
    assert found is None or found.p_value > 0.01
    assert EVIDENCE["hum"].signature(clues).p_value < 1e-10


# --- the picture ---------------------------------------------------------------------------------


def test_residual_views_draw_um_and_skip_what_is_unknown(scene):
    before = scene.change(PRESENT["play"], "play")[0]
    after = scene.noise(np.random.default_rng(14))[0]
    after[5:9] = np.nan
    figure = residual_views(np.arange(4000) * TS, scene.voltage[0], before, after, NOISE, TS, "play")
    course, *loops, spectrum = sorted(
        figure.axes, key=lambda a: (-a.get_position().y0, a.get_position().x0)
    )
    drawn = course.get_lines()[0].get_ydata()
    np.testing.assert_allclose(np.nanmax(drawn), np.max(before) / UM)
    assert {text.get_text() for text in loops[1].get_legend().get_texts()} >= {"rising", "falling"}
    density = [line.get_ydata() for line in spectrum.get_lines()]
    # white noise lies about the line that stands for it
    assert np.sqrt(np.mean(density[1] ** 2)) == pytest.approx(density[2][0], rel=0.1)
    assert png(figure).startswith(b"\x89PNG")
