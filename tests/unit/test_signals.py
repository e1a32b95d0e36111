"""Tables of input and output signals."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from it2hys.errors import InputError
from it2hys.records.signals import read_signals, write_signals

PLANT_INPUTS = ("voltage", "force", "temperature")


@pytest.fixture
def save(tmp_path):
    def write(text):
        path = tmp_path / "u.csv"
        path.write_text(text)
        return path

    return write


def test_the_wanted_quantities_are_read_and_the_others_ignored(save):
    path = save("time_ms,voltage_V,temperature [degC],remark,displacement\n0,1,20,a,9\n5,2,21,b,9\n")
    signals = read_signals(path, PLANT_INPUTS)
    assert signals.sample_time == 5e-3
    np.testing.assert_array_equal(signals.time, [0.0, 5e-3])
    assert signals.values.keys() == {"voltage", "temperature"}
    np.testing.assert_array_equal(signals.values["voltage"], [1.0, 2.0])
    np.testing.assert_array_equal(signals.values["temperature"], [293.15, 294.15])
    assert signals.notes == ()


def test_a_constant_signal_and_any_voltage_will_do(save):
    signals = read_signals(save("time_s,voltage\n1,9000\n2,9000\n3,9000\n"), PLANT_INPUTS)
    assert signals.sample_time == 1.0
    assert signals.notes == ("Column 'voltage' has no unit; taken as V.",)


def test_columns_by_other_names(save):
    path = save("t,yd\n0,1\n1e-4,2\n2e-4,3\n")
    columns = {"time": "t:s", "reference": "yd:um"}
    signals = read_signals(path, ("reference",), columns)
    assert signals.sample_time == 1e-4
    np.testing.assert_array_equal(signals.values["reference"], [1e-6, 2e-6, 3e-6])


@pytest.mark.parametrize(
    ("text", "phrase"),
    [
        ("", "the file is empty (zero bytes)"),
        ("voltage_V\n1\n2\n", "line 1: no column for time; the header has 'voltage_V'"),
        (
            "time_s,Vin\n0,1\n1,2\n",
            "line 1: no column for voltage or force or temperature; the header has 'time_s', "
            "'Vin'. Name it voltage_V or force_N or temperature_K, or map it by --column",
        ),
        ("time_s,voltage_A\n0,1\n1,2\n", "line 1: column 'voltage_A': unknown unit 'A'"),
        ("time_s,voltage_V\n0,1\n", "the file has one sample; at least 2 are needed"),
        ("time_s,voltage_V\n0,1\n1,x\n", "line 3: column 'voltage_V' has 'x' where a number"),
        ("time_s,voltage_V\n0,1\n1,nan\n", "line 3: column 'voltage_V' has nan where a finite"),
        ("time_s,voltage_V\n0,2\n0,1\n", "line 3: column 'time_s' repeats the time stamp 0 s"),
        ("time_s,voltage_V\n1,2\n0,1\n", "line 3: column 'time_s' falls from 1 s to 0 s"),
        (
            "time_s,voltage_V\n0,1\n1,2\n2,3\n5,4\n6,5\n",
            "line 5: a gap in time: 2 samples are missing between 2 s and 5 s (in the whole file "
            "2); these signals must be sampled uniformly",
        ),
        (
            "time_s,voltage_V\n0,1\n1,2\n2.2345678,3\n3,4\n4,4\n",
            "line 4: the time base jitters",
        ),
    ],
)
def test_bad_files_are_refused_with_the_place(save, text, phrase):
    path = save(text)
    with pytest.raises(InputError, match=re.escape(phrase)) as caught:
        read_signals(path, PLANT_INPUTS)
    assert str(caught.value).startswith(str(path))
    assert "--resample" not in str(caught.value)


def test_a_mapped_quantity_that_is_not_wanted_is_refused(save):
    path = save("time_s,voltage_V\n0,1\n1,2\n")
    with pytest.raises(InputError, match="unknown quantity 'reference'; known are time, voltage"):
        read_signals(path, ("voltage",), {"reference": "voltage_V"})


def test_the_written_file_is_for_people(tmp_path):
    time = np.arange(4) * 1e-4
    columns = {
        "voltage": (np.array([0.0, 50.0, 0.1 + 0.2, -1.0]), "V"),
        "displacement": (np.array([0.0, 1.5e-5, 1e-12, 1.0]), "um"),
        "measured": (np.zeros(4), "nm"),
        "saturated": (np.array([False, True, False, True]), "1"),
    }
    write_signals(tmp_path / "y.csv", time, columns)
    assert (tmp_path / "y.csv").read_text() == (
        "time_s,voltage_V,displacement_um,measured_nm,saturated\n"
        "0,0.0,0.0,0.0,0.0\n"
        "0.0001,50.0,15.0,0.0,1.0\n"
        "0.0002,0.30000000000000004,1e-06,0.0,0.0\n"
        "0.0003,-1.0,1000000.0,0.0,1.0\n"
    )


@given(values=st.lists(st.floats(-1e-2, 1e-2), min_size=2, max_size=20))
def test_what_is_written_reads_back_to_one_ulp(tmp_path_factory, values):
    path = tmp_path_factory.getbasetemp() / "y.csv"
    values = np.array(values)
    time = 0.1 + np.arange(values.size) * 1e-4
    write_signals(path, time, {"displacement": (values, "um"), "voltage": (values, "V")})
    again = read_signals(path, ("voltage", "displacement"))
    np.testing.assert_array_equal(again.values["voltage"], values)
    np.testing.assert_allclose(again.time, time, rtol=1e-14)
    difference = np.abs(again.values["displacement"] - values)
    assert np.all(difference <= np.spacing(np.abs(values)))


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    with pytest.raises(InputError, match=r"y\.csv: cannot be written"):
        write_signals(tmp_path / "none" / "y.csv", np.arange(2.0), {})
