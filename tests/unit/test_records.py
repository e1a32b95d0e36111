"""Reading of measured records: what is understood, what is refused and in which words."""

import re

import numpy as np
import pytest
from conftest import YAN9A, needs_measured_records
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from it2hys.errors import InputError
from it2hys.records import Record, parse_column_option, read_record, write_record
from it2hys.records.lead import samples_ahead
from it2hys.records.unused import unused_columns
from it2hys.stand import Stand, excitations

HEADER = "time_s,voltage_V,displacement_um"
COUNT = 200


def make_rows(count=COUNT, sample_time=1e-3):
    """Return time (s), voltage (V) and displacement (um) of a lagging stage, shape (count, 3)."""
    time = np.round(np.arange(count) * sample_time, 9)
    voltage = 50.0 - 50.0 * np.cos(2.0 * np.pi * 10.0 * time)
    lagged = 50.0 - 50.0 * np.cos(2.0 * np.pi * 10.0 * time - 0.3)
    noise = np.random.default_rng(0).normal(0.0, 0.01, count)
    return np.column_stack([time, voltage, 0.15 * lagged + noise])


def to_text(rows, header=HEADER, delimiter=","):
    lines = [delimiter.join(f"{value:.9g}" for value in row) for row in rows]
    return "\n".join([header, *lines]) + "\n"


def with_field(row, column, text):
    """Return the text of the record with one field replaced; row 0 is line 2."""
    lines = to_text(make_rows()).split("\n")
    parts = lines[row + 1].split(",")
    parts[column] = text
    lines[row + 1] = ",".join(parts)
    return "\n".join(lines)


def with_column(column, values, **options):
    rows = make_rows()
    rows[:, column] = values
    return to_text(rows, **options)


def with_rows_deleted(first, stop):
    return to_text(np.delete(make_rows(), np.s_[first:stop], axis=0))


@pytest.fixture
def save(tmp_path):
    def write(content, name="record.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


# --- what is understood --------------------------------------------------------------------------


@pytest.mark.parametrize(
    "transform",
    [
        lambda text: text,
        lambda text: "\ufeff" + text,
        lambda text: "# stage 7\n\n# 2024-05-01\n" + text,
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text + "\n\n  \n",
        lambda text: text.replace(",", ";"),
        lambda text: text.replace(",", "\t"),
        lambda text: text.replace(",", ";").replace(".", ","),
        lambda text: text.replace("\n0,", "\n0.0,").replace(",", ";").replace(".", ","),
        lambda text: text.replace("time_s,voltage_V", '"time_s","voltage_V"'),
        lambda text: text.replace(",", " , "),
        lambda text: text.replace("\n", ",ok\n").replace("um,ok", "um,remark"),
    ],
    ids=[
        "plain",
        "byte order mark",
        "comments",
        "crlf",
        "blank end",
        "semicolon",
        "tab",
        "decimal comma",
        "decimal comma in the first line",
        "quotes",
        "spaces",
        "text column",
    ],
)
def test_dialects_give_the_same_record(save, transform):
    record = read_record(save(transform(to_text(make_rows()))))
    time, voltage, displacement = make_rows().T
    assert record.name == "record"
    assert record.sample_time == 1e-3
    np.testing.assert_allclose(record.time, time, rtol=1e-8)
    np.testing.assert_allclose(record.voltage, voltage, rtol=1e-8)
    np.testing.assert_allclose(record.displacement, 1e-6 * displacement, rtol=1e-8)
    assert record.notes == ()
    assert not record.outliers.any()


@pytest.mark.parametrize(
    ("header", "scales"),
    [
        ("time_s,voltage_V,displacement_um", (1, 1, 1)),
        ("time_ms,voltage_mV,displacement_nm", (1e3, 1e3, 1e3)),
        ("time_us,voltage_kV,displacement_mm", (1e6, 1e-3, 1e-3)),
        ("Time_s,Voltage_V,Displacement_m", (1, 1, 1e-6)),
        ("time_s,voltage_uV,displacement_\u00b5m", (1, 1e6, 1)),
        ("time [ms],Voltage (V),displacement[\u00b5m]", (1e3, 1, 1)),
    ],
)
def test_units_are_read_from_the_header(save, header, scales):
    record = read_record(save(to_text(make_rows() * scales, header)))
    time, voltage, displacement = make_rows().T
    assert record.sample_time == 1e-3
    np.testing.assert_allclose(record.time, time, rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(record.voltage, voltage, rtol=1e-8)
    np.testing.assert_allclose(record.displacement, 1e-6 * displacement, rtol=1e-8)


def test_optional_columns(save):
    extra = np.tile([0.5, 20.0, 3.0], (COUNT, 1))
    header = HEADER + ",force_kN,temperature_degC,reference_um"
    record = read_record(save(to_text(np.hstack([make_rows(), extra]), header)))
    assert record.force[0] == 500.0
    assert record.temperature[0] == 293.15
    assert record.reference[0] == 3e-6


@pytest.mark.parametrize(
    ("header", "columns"),
    [
        ("time_s,Vin,displacement_um", {"voltage": "Vin"}),
        ("time_s,Vin_V,y", {"voltage": "Vin_V", "displacement": "y:um"}),
        ("t,Vin,y:1", {"time": "t", "voltage": ("Vin", "V"), "displacement": ("y:1", "um")}),
        ("time_s,U,displacement_nm", {"voltage": "U", "displacement": "displacement_nm:um"}),
        ("time_s,U [V],y (um)", {"voltage": "U [V]", "displacement": "y (um)"}),
    ],
)
def test_columns_by_other_names(save, header, columns):
    record = read_record(save(to_text(make_rows(), header)), columns=columns)
    np.testing.assert_allclose(record.voltage, make_rows()[:, 1], rtol=1e-8)
    np.testing.assert_allclose(record.displacement, 1e-6 * make_rows()[:, 2], rtol=1e-8)


def test_a_column_that_an_option_names_is_no_other_quantity(save):
    path = save(to_text(make_rows(), "time_s,velocity,force_kN"))
    record = read_record(path, {"voltage": "velocity:V", "displacement": "force_kN:um"})
    assert record.force is None and record.unused == ()


def test_columns_that_are_not_used_are_kept_by_name(save):
    rows = np.column_stack([make_rows(), np.ones((COUNT, 2))])
    record = read_record(save(to_text(rows, f"{HEADER},Temp (°C),counter")))
    assert record.unused == ("Temp (°C)", "counter")
    (sentence,) = unused_columns([record, record])
    assert sentence.startswith("Columns 'Temp (°C)', 'counter' of records 'record', 'record' are not")
    assert "--column 'temperature=Temp (°C):degC'" in sentence and "time alone" in sentence
    assert unused_columns([read_record(save(to_text(make_rows())))]) == []


def test_an_assumed_unit_is_noted(save):
    path = save(to_text(make_rows(), "time_s,Vin,displacement_um"))
    record = read_record(path, columns={"voltage": "Vin"})
    assert record.notes == ("Column 'Vin' has no unit; taken as V.",)


@pytest.mark.parametrize(
    ("option", "expected"),
    [
        ("voltage=Vin", ("voltage", "Vin", None)),
        ("voltage=Vin:mV", ("voltage", "Vin", "mV")),
        ("displacement = y (probe):\u00b5m", ("displacement", "y (probe)", "um")),
        ("reference=a:b:nm", ("reference", "a:b", "nm")),
    ],
)
def test_column_option(option, expected):
    assert parse_column_option(option) == expected


@pytest.mark.parametrize(
    ("option", "phrase"),
    [
        ("voltage", "the form is QUANTITY=NAME"),
        ("voltage=", "the form is QUANTITY=NAME"),
        ("current=I", "unknown quantity 'current'; known are time, voltage, displacement"),
        ("voltage=Vin:um", "unknown unit 'um' for voltage; known are V, mV, uV, kV"),
    ],
)
def test_bad_column_options_are_refused(option, phrase):
    with pytest.raises(InputError, match=re.escape(phrase)):
        parse_column_option(option)


# --- what is refused -----------------------------------------------------------------------------

BAD_FILES = {
    "zero bytes": (b"", "the file is empty (zero bytes)"),
    "comments only": ("# nothing\n\n", "there is no header, only blank lines and comments"),
    "header only": (HEADER + "\n\n", "there is only a header, no samples"),
    "no header": (to_text(make_rows()).split("\n", 1)[1], "line 1: a header is needed"),
    "utf-16": (to_text(make_rows()).encode("utf-16"), "line 1: this is not UTF-8 text"),
    "missing column": (
        to_text(make_rows(), "time_s,Vin,displacement_um"),
        "line 1: no column for voltage; the header has 'time_s', 'Vin', 'displacement_um'. Name "
        "it voltage_V, or map it by --column voltage=NAME:V",
    ),
    "names of a rig's own": (
        to_text(make_rows(), "t [s],u [V],x [um]"),
        "line 1: no column for time, voltage, displacement; the header has 't [s]', 'u [V]', "
        "'x [um]'. Name them time_s, voltage_V, displacement_um, or map them by "
        "--column 'time=t [s]' --column 'voltage=u [V]' --column 'displacement=x [um]'",
    ),
    "duplicated name": (
        to_text(make_rows(), "time_s,voltage_V,voltage_V"),
        "line 1: the header names column 'voltage_V' more than once",
    ),
    "two candidates": (
        to_text(make_rows()[:, [0, 1, 1, 2]], "time_s,voltage_V,voltage_mV,displacement_um"),
        "line 1: more than one column for voltage: 'voltage_V', 'voltage_mV'",
    ),
    "unknown unit": (
        to_text(make_rows(), "time_s,voltage_V,displacement_inch"),
        "line 1: column 'displacement_inch': unknown unit 'inch' for displacement; "
        "known are um, nm, mm, m",
    ),
    "unknown unit in brackets": (
        to_text(make_rows(), "time_s,voltage [A],displacement_um"),
        "line 1: column 'voltage [A]': unknown unit 'A' for voltage; known are V, mV, uV, kV",
    ),
    "no unit": (
        to_text(make_rows(), "time_s,voltage_V,displacement"),
        "line 1: column 'displacement' has no unit",
    ),
    "text": (
        with_field(5, 1, "overload"),
        "line 7: column 'voltage_V' has 'overload' where a number belongs",
    ),
    "grouped digits": (with_field(5, 1, "1_0"), "line 7: column 'voltage_V' has '1_0'"),
    "Arabic digits": (with_field(5, 1, "١٢"), "line 7: column 'voltage_V' has '١٢'"),
    "wide digits": (with_field(5, 1, "１.5"), "line 7: column 'voltage_V' has '１.5'"),
    "empty field": (with_field(8, 2, ""), "line 10: column 'displacement_um' is empty"),
    "nan": (with_field(9, 2, "NaN"), "line 11: column 'displacement_um' has nan"),
    "inf": (with_field(0, 1, "-inf"), "line 2: column 'voltage_V' has -inf"),
    "overflow": (with_field(3, 1, "1e999"), "line 5: column 'voltage_V' has inf"),
    "field too many": (
        with_field(4, 2, "1,5"),
        "line 6: the line has 4 fields, the header has 3; for a decimal comma",
    ),
    "line cut off": (
        to_text(make_rows()) + "0.2,5\n",
        "line 202: the line has 2 fields, the header has 3",
    ),
    "blank line": (
        to_text(make_rows()).replace("\n0.005,", "\n\n0.005,"),
        "line 7: the line is blank, but more samples follow",
    ),
    "five samples": (to_text(make_rows(5)), "the record has 5 samples, at least 50 are needed"),
    "gap": (
        with_rows_deleted(40, 43),
        "line 42: a gap in time: 3 samples are missing between 0.039 s and 0.043 s",
    ),
    "repeated stamp": (
        with_field(20, 0, "0.019"),
        "line 22: column 'time_s' repeats the time stamp 0.019 s",
    ),
    "falling stamp": (
        with_field(20, 0, "0.0185"),
        "line 22: column 'time_s' falls from 0.019 s to 0.0185 s",
    ),
    "jitter": (
        with_column(0, make_rows()[:, 0] + 1e-4 * np.sin(np.arange(COUNT))),
        "of the sample time 0.001 s away from a uniform grid; --resample",
    ),
    "one stray stamp": (
        with_field(20, 0, "0.0203412345"),
        "line 22: the time base jitters: the stamp 0.0203412345 s is 34 %",
    ),
    "time and voltage swapped": (
        to_text(make_rows()[:, [1, 0, 2]]),
        "column 'time_s' does not rise, but 'voltage_V' rises evenly: the columns look swapped",
    ),
    "voltage and displacement swapped": (
        to_text(make_rows()[:, [0, 2, 1]]),
        "line 1: the displacement leads the voltage by about 5 samples: the columns look swapped; "
        "map them with --column voltage=displacement_um:V --column displacement=voltage_V:um",
    ),
    "constant voltage": (with_column(1, 5.0), "column 'voltage_V' is constant"),
    "constant displacement": (with_column(2, 5.0), "column 'displacement_um' is constant"),
    "voltage too large": (
        with_column(1, 1e3 * make_rows()[:, 1]),
        "column 'voltage_V' has 1e+05 V when read in V",
    ),
    "displacement too large": (
        with_column(2, 1e3 * make_rows()[:, 2]),
        "µm when read in um, which no piezo stage has: the unit looks wrong",
    ),
    "displacement too small": (
        with_column(2, 1e-6 * make_rows()[:, 2]),
        "µm when read in um, which no piezo stage has: the unit looks wrong",
    ),
}


@pytest.mark.parametrize(("content", "phrase"), BAD_FILES.values(), ids=BAD_FILES.keys())
def test_bad_files_are_refused_with_the_place(save, content, phrase):
    path = save(content)
    with pytest.raises(InputError) as caught:
        read_record(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert phrase in message
    assert "\n" not in message


def test_what_is_no_file_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"none\.csv: there is no such file"):
        read_record(tmp_path / "none.csv")
    with pytest.raises(InputError, match="this is a directory"):
        read_record(tmp_path)


def test_a_mapped_column_that_is_missing_is_named(save):
    with pytest.raises(InputError, match="line 1: no column 'U' for voltage; the header has"):
        read_record(save(to_text(make_rows())), columns={"voltage": "U"})


# --- the time base -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("stamps", "sample_time"),
    [
        (26.0 + np.arange(COUNT) * 1e-4, 1e-4),
        (np.arange(COUNT) * 0.005, 0.005),
        (np.round(np.arange(COUNT) * 1.5e-3, 3), 1.5e-3),  # stamps 0, 0.002, 0.003, 0.004, ...
        (np.arange(COUNT) / 51200.0, 1.953125e-5),
        (-1.0 + np.arange(COUNT) * 1e-3, 1e-3),
    ],
)
def test_sample_time_is_exact_in_spite_of_rounded_stamps(save, stamps, sample_time):
    record = read_record(save(with_column(0, stamps)))
    assert record.sample_time == sample_time
    np.testing.assert_allclose(record.time, stamps, atol=1e-8)


def test_missing_samples_are_filled_in_and_carry_no_weight(save):
    path = save(with_rows_deleted(40, 43))
    record = read_record(path, resample=True)
    assert len(record) == COUNT
    np.testing.assert_array_equal(np.flatnonzero(record.outliers), [40, 41, 42])
    np.testing.assert_allclose(record.time, make_rows()[:, 0], atol=1e-12)
    np.testing.assert_allclose(record.voltage, make_rows()[:, 1], atol=0.4)
    assert "3 were missing" in record.notes[-1]


def test_one_per_cent_missing_and_jitter_are_mended(save):
    rng = np.random.default_rng(2)
    rows = make_rows(1000)
    true_time = rows[:, 0] + rng.uniform(-1e-4, 1e-4, 1000)
    rows[:, 0] = true_time
    rows[:, 1] = 50.0 - 50.0 * np.cos(2.0 * np.pi * 10.0 * true_time)
    rows = np.delete(rows, rng.choice(np.arange(5, 995), 10, replace=False), axis=0)
    path = save(to_text(rows))
    with pytest.raises(InputError, match="--resample"):
        read_record(path)
    record = read_record(path, resample=True)
    assert record.sample_time == pytest.approx(1e-3, rel=1e-5)
    expected = 50.0 - 50.0 * np.cos(2.0 * np.pi * 10.0 * record.time)
    np.testing.assert_allclose(record.voltage, expected, atol=0.15)


@pytest.mark.parametrize(
    ("rows", "phrase"),
    [
        (np.delete(make_rows(), np.s_[40:65], axis=0), "line 42: a gap in time of 25 samples"),
        (np.delete(make_rows(), np.s_[20::10], axis=0), "of the samples are missing, at most 5 %"),
    ],
)
def test_resampling_has_limits(save, rows, phrase):
    with pytest.raises(InputError, match=phrase):
        read_record(save(to_text(rows)), resample=True)


def test_a_wanted_sample_time_is_checked_or_made(save):
    path = save(to_text(make_rows()))
    assert read_record(path, sample_time=1e-3).sample_time == 1e-3
    with pytest.raises(InputError, match=r"the sample time is 0\.001 s, not 0\.0005 s"):
        read_record(path, sample_time=5e-4)
    record = read_record(path, resample=True, sample_time=5e-4)
    assert record.sample_time == 5e-4
    assert len(record) == 2 * COUNT - 1
    assert not record.outliers.any()
    for bad in (1e-9, -1.0, float("nan")):
        with pytest.raises(InputError, match=r"a factor from 0\.01 to 100"):
            read_record(path, resample=True, sample_time=bad)


# --- what is noted -------------------------------------------------------------------------------


def test_an_outlier_is_kept_named_and_masked(save):
    record = read_record(save(with_field(60, 2, "9")))
    np.testing.assert_array_equal(np.flatnonzero(record.outliers), [60])
    assert record.displacement[60] == 9e-6
    assert record.notes == (
        "The displacement has 1 single-sample outlier, the first in line 62; "
        "kept, but given no weight.",
    )


def test_a_clipped_sensor_is_noted_and_masked(save):
    displacement = make_rows()[:, 2]
    record = read_record(save(with_column(2, np.minimum(displacement, 12.0))))
    np.testing.assert_array_equal(record.outliers, displacement > 12.0)
    assert "stays at its maximum: the sensor looks clipped; 2 stretches" in record.notes[0]


def test_a_stuck_reading_is_noted_and_masked(save):
    displacement = make_rows()[:, 2].copy()
    displacement[20:30] = displacement[20]
    record = read_record(save(with_column(2, displacement)))
    np.testing.assert_array_equal(np.flatnonzero(record.outliers), np.arange(20, 30))
    assert "stays at one value: the reading looks stuck" in record.notes[0]


def test_a_saturated_drive_is_noted(save):
    record = read_record(save(with_column(1, np.minimum(make_rows()[:, 1], 90.0))))
    assert "The voltage runs into 90 V, an end of its range" in record.notes[0]
    assert not record.outliers.any()


def test_a_displacement_ahead_of_its_voltage_may_be_let_pass_with_a_note(save):
    record = read_record(save(to_text(make_rows()[:, [0, 2, 1]])), check_swapped=False)
    assert "leads the voltage by about 5 samples, which is not causal" in record.notes[0]


def test_a_reversed_sensor_is_noted_where_it_may_be_a_delay_of_half_a_cycle(save):
    rows = make_rows()
    phase = 2.0 * np.pi * 100.0 * rows[:, 0]
    rows[:, 1:] = np.column_stack([50.0 - 50.0 * np.cos(phase), 7.5 * np.cos(phase - 0.3)])
    record = read_record(save(to_text(rows)))
    assert "check the sensor's sign" in record.notes[0]


@pytest.mark.parametrize(
    "signal",
    [
        excitations.triangle,
        excitations.identification,
        lambda t: excitations.steps(t, [0.0, 50.0, 100.0, 20.0], 0.03),
        lambda t: np.round(excitations.sine(t, 5.0) / 105.0 * 4096) / 4096 * 105.0,
        lambda t: excitations.chirp(t, 2.0, 200.0, 0.2),
        lambda t: np.random.default_rng(5).uniform(0.0, 100.0, t.shape),
    ],
    ids=["triangle", "two tones", "steps", "quantised", "chirp", "random"],
)
def test_sound_records_give_no_finding(save, signal):
    time = excitations.time_grid(0.2, 1e-4)
    voltage = signal(time)
    displacement = np.empty_like(voltage)
    state = voltage[0]
    for k, value in enumerate(voltage):
        state += 0.2 * (value - state)
        displacement[k] = 0.15 * state
    record = read_record(save(to_text(np.column_stack([time, voltage, displacement]))))
    assert record.notes == ()
    assert not record.outliers.any()


# --- exchanged columns ---------------------------------------------------------------------------

RIG_TIME = excitations.time_grid(0.2, 1e-4)
RIG_VOLTAGES = {
    "triangle": excitations.triangle(RIG_TIME),
    "two tones": excitations.identification(RIG_TIME),
    "slow sine": excitations.sine(RIG_TIME, 10.0),
    "fast sine": excitations.sine(RIG_TIME, 100.0),
    "decaying": excitations.decaying(RIG_TIME, 50.0, 0.1),
    "steps": excitations.steps(RIG_TIME, [0.0, 50.0, 100.0, 20.0, 80.0, 10.0], 0.03),
    "two levels": 100.0 * np.repeat(np.random.default_rng(3).integers(0, 2, 100), 20),
}


@pytest.fixture
def save_record(tmp_path):
    """Return a writer of voltage (V) and displacement (m), with names as they are or exchanged."""

    def write(voltage, displacement, header=HEADER, sample_time=1e-4):
        time = np.arange(len(voltage)) * sample_time
        path = tmp_path / "record.csv"
        table = np.column_stack([time, voltage, 1e6 * displacement])
        np.savetxt(path, table, "%.9g", delimiter=",", header=header, comments="")
        return path

    return write


@pytest.mark.parametrize("voltage", RIG_VOLTAGES.values(), ids=RIG_VOLTAGES.keys())
def test_exchanged_columns_are_refused_and_the_advice_mends_them(save_record, voltage):
    made = Stand().record(voltage, "rig")
    assert "leads" not in " ".join(read_record(save_record(voltage, made.displacement)).notes)
    path = save_record(voltage, made.displacement, "time_s,displacement_um,voltage_V")
    with pytest.raises(InputError, match="line 1: the displacement leads the voltage by") as caught:
        read_record(path)
    advice = re.findall(r"--column (\S+)", str(caught.value))
    assert advice == ["voltage=displacement_um:V", "displacement=voltage_V:um"]
    columns = {quantity: (name, unit) for quantity, name, unit in map(parse_column_option, advice)}
    record = read_record(path, columns)
    np.testing.assert_allclose(record.displacement, made.displacement, rtol=1e-8, atol=1e-15)


def rig(frequency, **parts):
    voltage = excitations.sine(RIG_TIME, frequency)
    return voltage, Stand(**parts).record(voltage, "rig").displacement


def regulated(reference, seed):
    """Return voltage (V) and displacement (m) of a stage under feedback, strongly disturbed."""
    running = Stand().start(seed)
    rng = np.random.default_rng(seed)
    push = np.convolve(rng.normal(0.0, 40.0, len(reference) + 49), np.ones(50) / 7.0, "valid")
    voltage, displacement = np.zeros((2, len(reference)))
    for k in range(1, len(reference)):
        error = reference[k] - displacement[k - 1]
        voltage[k] = voltage[k - 1] + 2e6 * error
        displacement[k] = running.step(voltage[k], force=push[k])
    return voltage, displacement


def drifting(slope):
    voltage, displacement = rig(25.0)
    return voltage, displacement + slope * RIG_TIME


def noisy(level, seed):
    voltage = excitations.triangle(RIG_TIME)
    return voltage, 1e-7 * voltage + np.random.default_rng(seed).normal(0.0, level, voltage.size)


def coarse_steps(overshoot):
    """Return the record of a stage that rings faster than it is sampled."""
    voltage = 100.0 * np.repeat(np.random.default_rng(4).integers(0, 2, 100), 10)
    change = np.diff(voltage, prepend=voltage[0])
    return voltage, 1e-7 * (voltage + overshoot * change)


def bent_curve():
    voltage = excitations.decaying(RIG_TIME, 50.0, 0.1)
    return voltage, 1e-9 * np.square(voltage)


CORRECT = {
    "below the resonance": lambda: rig(500.0),
    "near the resonance": lambda: rig(1000.0),
    "late by most of a period": lambda: rig(820.0, dead_time=1e-3),
    "above the resonance, in antiphase": lambda: rig(2000.0),
    "dead time": lambda: rig(400.0, dead_time=5e-4),
    "no lag": lambda: rig(25.0, hysteresis=None, creep=None, amplifier=None, mechanics=None),
    "one half of a cycle": lambda: rig(2.5),
    "a chirp through the resonance": lambda: (
        (voltage := excitations.chirp(RIG_TIME, 10.0, 3000.0, 0.2)),
        Stand(dead_time=2e-4).record(voltage, "rig").displacement,
    ),
    "drift upwards": lambda: drifting(5e-5),
    "drift downwards": lambda: drifting(-5e-5),
    "noise": lambda: noisy(1e-6, 1),
    "much noise": lambda: noisy(5e-6, 2),
    "overshoot": lambda: coarse_steps(0.7),
    "a bent curve": bent_curve,
    "a regulator that tracks": lambda: regulated(1e-6 * (7 - 6 * np.cos(200 * RIG_TIME)), 1),
    "a regulator that holds": lambda: regulated(np.full(RIG_TIME.size, 7e-6), 2),
}


@pytest.mark.parametrize("make", CORRECT.values(), ids=CORRECT.keys())
def test_columns_in_order_are_never_called_exchanged(save_record, make):
    voltage, displacement = make()
    notes = read_record(save_record(voltage, displacement)).notes
    assert not any("leads" in note for note in notes)


def test_a_reversed_sensor_is_called_that_and_not_exchanged(save_record):
    voltage, displacement = rig(25.0)
    with pytest.raises(InputError, match=r"falls by 14.* the sensor's sign is reversed"):
        read_record(save_record(voltage, -displacement))


@given(
    seed=st.integers(0, 2**32 - 1),
    pole=st.floats(0.05, 0.95),
    smooth=st.integers(1, 40),
    noise=st.floats(0.0, 0.3),
)
def test_no_lag_is_taken_for_a_lead(seed, pole, smooth, noise):
    rng = np.random.default_rng(seed)
    voltage = np.convolve(rng.normal(size=400 + smooth), np.ones(smooth), "valid")
    displacement = lfilter([1.0 - pole], [1.0, -pole], voltage)
    displacement += noise * displacement.std() * rng.normal(size=voltage.size)
    assert samples_ahead(voltage, displacement) == 0


# --- the record, and writing it ------------------------------------------------------------------


def make_record(seed=0, count=80, sample_time=1e-4, start=0.0, stroke=1e-5, optional=False):
    rng = np.random.default_rng(seed)
    time = start + np.arange(count) * sample_time
    extra = rng.normal(300.0, 1.0, (3, count)) if optional else (None, None, None)
    return Record(
        name="made",
        time=time,
        voltage=50.0 + 50.0 * np.sin(0.2 * np.arange(count)) + rng.normal(0.0, 0.1, count),
        displacement=stroke * (np.sin(0.2 * np.arange(count) - 0.3) + rng.normal(0.0, 0.01, count)),
        sample_time=sample_time,
        force=extra[0],
        temperature=extra[1],
        reference=extra[2],
    )


@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(50, 120),
    sample_time=st.sampled_from([1e-5, 1e-4, 2.5e-4, 5e-3, 1.0]),
    start=st.sampled_from([0.0, 0.1, 26.0, -3.0]),
    stroke=st.floats(1e-8, 1e-3),
    optional=st.booleans(),
)
def test_round_trip(tmp_path_factory, seed, count, sample_time, start, stroke, optional):
    record = make_record(seed, count, sample_time, start, stroke, optional)
    path = tmp_path_factory.getbasetemp() / "round_trip.csv"
    write_record(path, record)
    again = read_record(path)
    assert again.sample_time == record.sample_time
    for name in ("time", "voltage", "displacement", "force", "temperature", "reference"):
        written, read = getattr(record, name), getattr(again, name)
        if written is None:
            assert read is None
        else:
            np.testing.assert_allclose(read, written, rtol=1e-13, atol=1e-14 * np.ptp(written))


def test_the_written_file_is_for_people(tmp_path):
    write_record(tmp_path / "made.csv", make_record(optional=True))
    header, first = (tmp_path / "made.csv").read_text().split("\n")[:2]
    assert header == "time_s,voltage_V,displacement_um,force_N,temperature_degC,reference_um"
    assert first.startswith("0,")


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "made.csv"
    path.write_text("old")

    def full_disk(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("it2hys.support.files.os.replace", full_disk)
    with pytest.raises(InputError, match=r"made\.csv: cannot be written: No space left"):
        write_record(path, make_record())
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").touch()
    for parent in ("none", "file"):
        with pytest.raises(InputError, match=r"made\.csv: cannot be written"):
            write_record(tmp_path / parent / "made.csv", make_record())


def test_slice_cuts_every_signal():
    part = make_record(optional=True).slice(10, -10)
    assert len(part) == 60
    assert part.time[0] == pytest.approx(1e-3)
    assert len(part.force) == len(part.outliers) == 60
    assert part.sample_time == 1e-4


@pytest.mark.parametrize(
    ("changes", "phrase"),
    [
        ({"voltage": np.zeros(3)}, r"voltage has shape \(3,\), time has \(4,\)"),
        ({"outliers": np.zeros(2, bool)}, r"outliers has shape \(2,\)"),
        ({"sample_time": 0.0}, "the sample time must be positive"),
    ],
)
def test_an_inconsistent_record_is_refused(changes, phrase):
    arguments = {
        "name": "odd",
        "time": np.arange(4.0),
        "voltage": np.arange(4.0),
        "displacement": np.arange(4.0),
        "sample_time": 1.0,
    }
    with pytest.raises(InputError, match=phrase):
        Record(**(arguments | changes))


# --- measured data -------------------------------------------------------------------------------


@needs_measured_records
@pytest.mark.parametrize(
    ("name", "count", "start"),
    [("train", 8027, 0.0), ("minor_loops", 5200, 0.0), ("test", 8955, 26.0)],
)
def test_measured_data(name, count, start, save):
    record = read_record(YAN9A / f"{name}.csv")
    assert len(record) == count
    assert record.sample_time == 0.005
    assert record.time[0] == start
    assert (record.reference is None) == (name == "train")
    assert not record.outliers.any()
    lines = (YAN9A / f"{name}.csv").read_text().split("\n", 1)
    swapped = lines[0].replace("voltage_V,displacement_um", "displacement_um,voltage_V")
    with pytest.raises(InputError, match="line 1: the displacement leads the voltage by about 7"):
        read_record(save("\n".join([swapped, lines[1]])))
