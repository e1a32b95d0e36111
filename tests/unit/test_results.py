"""The package in notebooks: its names, and results that show themselves."""

import inspect
import io
import typing
from contextlib import redirect_stderr
from importlib.resources import files

import numpy as np
import pytest
from matplotlib.figure import Figure

import it2hys
from it2hys.model import compiled
from it2hys.records import Record
from it2hys.reports.summary import summary

RULES = np.array([[5e-6, 15e-6, 8e-6, 0.9, 1.5e-8, 1e-7]])


def measured(seed):
    """Return a record of a model with one rule."""
    time = np.arange(800) * 1e-4
    voltage = 50 - 50 * np.cos(2 * np.pi * 50 * time)
    noise = 5e-9 * np.random.default_rng(seed).standard_normal(len(time))
    displacement = compiled.free_run(RULES, voltage, 1e-6) + noise
    return {"time_s": time, "voltage_V": voltage, "displacement_m": displacement}


@pytest.fixture(scope="module")
def record():
    return measured(0)


@pytest.fixture(scope="module")
def found(record):
    return it2hys.identify(record, test=[measured(1)], rules=1)


def test_every_public_name_is_documented_and_typed():
    assert (files("it2hys") / "py.typed").is_file()
    assert set(it2hys.__all__) <= set(dir(it2hys))
    for name in set(it2hys.__all__) - {"__version__"}:
        thing = getattr(it2hys, name)
        assert inspect.getdoc(thing), name
        if inspect.isfunction(thing):
            hints = typing.get_type_hints(thing)
            assert set(hints) == {*inspect.signature(thing).parameters, "return"}, name
            assert "Returns\n-------" in inspect.getdoc(thing), name
    assert issubclass(it2hys.InputError, Exception)


def test_the_errors_of_a_result_are_a_frame(found):
    frame = found.to_frame()
    assert frame["record"].to_list() == ["train_1", "test_1"]
    assert frame["role"].to_list() == ["train", "test"]
    for row, judged in zip(frame.to_dicts(), found.records, strict=True):
        assert row["e_rms_um"] == pytest.approx(judged.e_rms * 1e6)
        assert row["e_rms_um"] == pytest.approx(5e-3, rel=0.2)  # the noise
        assert row["inverse_e_rms_V"] == judged.inverse.e_rms


def test_a_result_draws_the_loop_of_a_record(found, record):
    figure = found.plot("test_1")
    assert isinstance(figure, Figure)
    drawn = figure.axes[0].get_lines()[0]
    assert np.ptp(drawn.get_xdata()) == pytest.approx(100.0)
    assert np.ptp(drawn.get_ydata()) == pytest.approx(np.ptp(record["displacement_m"]) * 1e6, rel=0.01)
    with pytest.raises(it2hys.InputError, match="no record 'test'; did you mean 'test_1'"):
        found.plot("test")
    with pytest.raises(it2hys.InputError, match="no record 2; there are 2"):
        found.plot(2)


def test_a_notebook_shows_a_result_as_table_and_picture(found):
    page = found._repr_html_()
    assert "Identified model, 1 rule<" in page and "test_1" in page
    assert page.count("<table") == 1 and 'src="data:image/png;base64,iVBOR' in page


def test_a_diagnosis_shows_before_and_after(record):
    time = record["time_s"]
    force = 10 - 10 * np.cos(2 * np.pi * 17 * time)
    loaded = {**record, "force_N": force, "displacement_m": record["displacement_m"] - 2e-8 * force}
    steps = []
    found = it2hys.diagnose(loaded, rules=1, progress=lambda share, text: steps.append((share, text)))
    assert found.effects == ("load",)
    frame = found.to_frame()
    assert frame["model"].to_list() == ["before", "after"]
    before, after = frame["e_rms_um"]
    assert after < 0.1 * before
    assert len(found.plot().axes[0].get_lines()) == 3
    assert "load" in found._repr_html_()
    shares = [share for share, _ in steps]
    assert len(shares) > 5 and min(shares) >= 0 and max(shares) <= 1 and steps[-1][1]


def test_progress_is_shown_where_it_is_asked_for(record):
    for progress, shown in ((True, "100%"), (False, "")):
        with redirect_stderr(io.StringIO()) as said:
            it2hys.identify(record, rules=1, progress=progress)
        assert shown in said.getvalue() and bool(said.getvalue()) is progress


def test_the_range_of_references_is_that_behind_the_lead_in():
    """A stage may begin where none of the record's voltages brings it again."""
    signals = measured(2)
    voltage = signals["voltage_V"]
    reading = compiled.free_run(RULES, voltage, -4e-6) + signals["displacement_m"]
    reading -= compiled.free_run(RULES, voltage, 1e-6)  # the noise is left
    record = Record("one", signals["time_s"], voltage, reading, 1e-4)
    found = it2hys.identify(record, rules=1)
    low, high = summary(found, [record])["range"]["displacement_um"]
    behind = 1e6 * reading[found.records[0].lead :]
    assert reading.min() < -3e-6 and low > 0.0
    assert (low, high) == pytest.approx((behind.min(), behind.max()))
