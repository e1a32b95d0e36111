"""The page of a report, in a browser and out of it: what it says first, and figures to look into."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from html import unescape
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from browser import Browser, needs_browser
from test_cli import html_of, run
from test_diagnose import COMPLIANCE, ROLES, UM, diagnose, stage_with, write_all

from it2hys.reports.courses import SIGNALS, make_course, write_courses

SCHEMA = json.loads((Path(__file__).parents[2] / "docs" / "report.schema.json").read_text())
LARGEST = 8_000_000
#: Leaves effects out, to be quick.
OTHERS = ("--exclude", "slew,saturation,resonance,nonlinearity")
QUESTIONS = [
    "What was found", "How good the pair is", "Use as feedforward", "What is not explained",
    "What to measure next",
]  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Diagnose a stage with two effects, into `out`."""
    folder = tmp_path_factory.mktemp("stage")
    hum = {"hum.amplitude": 0.06 * UM, "hum.frequency": 150.0}
    write_all(folder, stage_with(**{"load.compliance": COMPLIANCE}, **hum))
    assert diagnose(folder, folder / "out", "--seed", 3, *OTHERS, "--quiet") == 0
    return folder


@pytest.fixture(scope="module")
def identified(folder):
    """Identify the same stage, without its effects, into `plain`."""
    out = folder / "plain"
    tests = ["--test", folder / "t.csv"]
    assert run("identify", folder / "a.csv", *tests, "--rules", 1, "-o", out, "--quiet") == 0
    return out


def report_of(out):
    return json.loads((out / "report.json").read_text(encoding="utf-8"))


def words(html):
    return unescape(re.sub(r"<[^>]*>", " ", html))


# --- what it says ----------------------------------------------------------------------------------


@pytest.mark.parametrize("which", ["out", "plain"])
def test_a_page_answers_five_questions_in_order_before_anything_else(folder, identified, which):
    page = html_of(folder / which)
    assert re.findall(r"<h3>(.*?)</h3>", page) == QUESTIONS
    top = page[: page.index("<h2>")]
    assert all(f"<h3>{question}</h3>\n<p>" in top for question in QUESTIONS)
    assert top.count("<img") == 2  # the loop, and how the error falls


def test_the_table_at_the_top_is_of_the_test_record(folder):
    report, page = report_of(folder / "out"), html_of(folder / "out")
    table = words(page[page.index("<table>") : page.index("</table>")])
    for when in ("before", "after"):
        entry = report["error"][when]["t"]
        plant, volts = entry["e_rms_um"], entry["inverse_e_rms_V"]
        found = [float(n) for n in re.findall(r"([\d.]+) µm \(", table)]
        assert any(n == pytest.approx(plant, rel=0.01) for n in found)
        found = [float(n) for n in re.findall(r"([\d.]+) V \(", table)]
        assert any(n == pytest.approx(volts, rel=0.01) for n in found)
    share = 100 * report["error"]["after"]["t"]["e_rms_um"] / report["error"]["after"]["t"]["range_um"]
    assert f"({share:.2f} %)" in table


def test_the_top_says_range_and_band_of_feedforward(folder):
    report, page = report_of(folder / "out"), words(html_of(folder / "out"))
    low, high = report["range"]["displacement_um"]
    found = re.search(r"Yes, for references from ([\d.-]+) to ([\d.-]+) µm .* up to ([\d.]+) Hz", page)
    assert [float(n) for n in found.groups()[:2]] == pytest.approx([low, high], rel=0.01)
    driven = max(entry["driven_up_to_Hz"] for entry in report["records"].values())
    band = min(driven, report["error"]["after"]["t"]["inverse_band_Hz"])
    assert float(found[3]) == pytest.approx(band, rel=0.01)
    assert ("as fast as the records are driven" in page) == (band == driven)


def test_the_largest_error_has_its_time(folder):
    report = report_of(folder / "out")
    entry = report["error"]["after"]["t"]
    assert f"in record t at {entry['e_mr_at_s']:.6g} s" in words(html_of(folder / "out"))
    time = np.loadtxt(folder / "t.csv", delimiter=",", skiprows=1)[:, 0]
    assert np.min(np.abs(time - entry["e_mr_at_s"])) < 1e-9


def test_every_step_is_measured_on_the_same_records(folder):
    """The error falls with every effect, from the model before to the model now."""
    report = report_of(folder / "out")
    assert [step["added"] for step in report["steps"]] == [["load"], ["hum"]]
    for key in ("e_rms_um", "inverse_e_rms_V"):
        for name in ROLES:
            errors = [report["error"]["before"][name][key]]
            errors += [step["error"][name][key] for step in report["steps"]]
            assert errors == sorted(errors, reverse=True)
            assert errors[-1] == report["error"]["after"][name][key]


@pytest.mark.parametrize("which", ["out", "plain"])
def test_what_is_not_determined_is_called_so_and_what_is_has_an_interval(folder, identified, which):
    report, page = report_of(folder / which), words(html_of(folder / which))
    assert not report["parameters"]["rule[1].sigmaLower"]["determined"]
    assert re.search(r"rule\[1\]\.sigmaLower\s+[\d.e+]+\s+not determined\s+µm", page)
    figures = {f["name"]: f for f in report["stage_figures"]}
    assert {"gain", "loop width", "time constant"} <= set(figures)
    for figure in figures.values():
        low, high = figure["ci95"]
        assert low < figure["value"] < high
    shown = re.search(r"gain over .*? records\s+([\d.]+)\s+([\d.]+) to ([\d.]+)\s+µm/V", page)
    gain = figures["gain"]
    expected = [1e6 * value for value in (gain["value"], *gain["ci95"])]
    assert [float(n) for n in shown.groups()] == pytest.approx(expected, rel=1e-3)


def test_no_interval_on_a_page_is_wider_than_it_is_worth(folder, identified):
    for which in ("out", "plain"):
        for low, high in re.findall(r"(-?[\d.]+) to (-?[\d.]+)", words(html_of(folder / which))):
            assert float(high) - float(low) < 1e5


def test_a_reason_of_several_effects_is_said_once(folder):
    page, evidence = html_of(folder / "out"), report_of(folder / "out")["evidence"]
    assert "changes the free-run error on" not in page
    reasons = [e["reason"] for e in evidence if not e["accepted"] and "excluded" not in e["reason"]]
    assert max(map(reasons.count, reasons)) >= 3
    for reason in {*reasons}:
        assert page.count(f"{reason};") + page.count(f"{reason}</td>") == 1, reason


def test_text_in_tables_begins_at_the_left(folder):
    page = html_of(folder / "out")
    for attributes, cell in re.findall(r"<td([^>]*)>(.*?)</td>", page):
        is_text = bool(re.search(r"[A-Za-z]{3}", cell))
        assert not (is_text and "figure" in attributes), cell


def test_pages_say_um_as_people_write_it(folder, identified):
    for which in ("out", "plain"):
        text = words(html_of(folder / which))
        assert not re.search(r"\d um\b", text) and "(s)" not in text


# --- where it comes from ---------------------------------------------------------------------------


@pytest.mark.parametrize("which", ["out", "plain"])
def test_the_report_follows_its_schema_and_no_key_is_undocumented(folder, identified, which):
    jsonschema.validate(report_of(folder / which), SCHEMA)


def test_the_report_says_what_it_was_made_by_and_of(folder):
    report = report_of(folder / "out")
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\+00:00", report["date"])
    assert report["seed"] == 3
    assert report["command"].startswith("it2hys diagnose ") and "--seed 3" in report["command"]
    assert {i["name"]: i["role"] for i in report["inputs"]} == ROLES
    for entry in report["inputs"]:
        content = (folder / f"{entry['name']}.csv").read_bytes()
        assert entry["sha256"] == hashlib.sha256(content).hexdigest()
        assert entry["sha256"] in html_of(folder / "out")


def test_the_page_is_drawn_again_from_its_directory(folder, tmp_path, capsys):
    out = shutil.copytree(folder / "out", tmp_path / "copy")
    first = html_of(out)
    for name in ("report.html", "waterfall.png", "IT2Plant.fmu", "IT2Inverse.fmu"):
        (out / name).unlink()
    assert run("report", out) == 0
    assert str(out / "report.html") in capsys.readouterr().out
    assert html_of(out) == first


def test_what_is_changed_in_the_json_changes_on_the_page(folder, tmp_path):
    out = shutil.copytree(folder / "out", tmp_path / "copy")
    text = (out / "report.json").read_text(encoding="utf-8")
    (out / "report.json").write_text(text.replace('"title": "Diagnosis"', '"title": "Stage 7"'))
    assert run("report", out, "--quiet") == 0
    assert "<h1>Stage 7</h1>" in html_of(out)


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda out: (out / "report.json").unlink(), ["report.json", "no such file", "-o"]),
        (lambda out: (out / "report.json").write_text("{"), ["report.json", "cannot be read"]),
        (lambda out: (out / "report.json").write_text('{"effects": []}'), ["title", "earlier version"]),
        (lambda out: (out / "courses.npz").unlink(), ["courses.npz", "no such file"]),
        (lambda out: (out / "courses.npz").write_bytes(b"PK"), ["courses.npz", "damaged"]),
        (lambda out: (out / "overview.png").unlink(), ["overview.png", "figure"]),
    ],
)
def test_a_directory_that_holds_no_whole_report_is_refused(folder, tmp_path, capsys, damage, words):
    out = shutil.copytree(folder / "out", tmp_path / "copy")
    before = (out / "report.html").read_bytes()
    damage(out)
    assert run("report", out) == 2
    message = capsys.readouterr().err
    assert len(message.strip().splitlines()) == 1 and all(word in message for word in words), message
    assert (out / "report.html").read_bytes() == before


# --- figures to look into --------------------------------------------------------------------------

HELPERS = """
window.plot = (name) => Bokeh.documents[0].get_model_by_name(name);
window.box = (name) => {
  const box = Bokeh.index.find_one(plot(name)).el.getBoundingClientRect();
  return [box.left, box.top, box.width, box.height];
};
window.ends = (range) => [range.start, range.end];
window.shown = () => plot("error").renderers[0].data_source;
window.full = () => plot("voltage").x_range.js_property_callbacks["change:start"][0].args.full;
0
"""
DRAWN = "window.Bokeh && Bokeh.documents.length > 0 && Bokeh.documents[0].is_idle"


@pytest.fixture(scope="module")
def browser():
    """Start one browser for all tests."""
    with Browser() as browser:
        yield browser


@pytest.fixture
def looked_at(folder, browser):
    """Open the page of the diagnosis at its figures."""
    return look_at(browser, folder / "out")


def look_at(browser, out):
    browser.errors.clear()
    browser.open(out / "report.html")
    browser.until(DRAWN)
    browser.run(HELPERS)
    browser.run("document.querySelector('details.figures').scrollIntoView(); 0")
    # drawn at least once by its own script
    browser.until("shown().data.place.length > 0")
    return browser


def inside(browser, name, across, down):
    """Return a place within a figure, by shares of its width and height."""
    left, top, width, height = browser.run(f"box('{name}')")
    return left + across * width, top + down * height


@needs_browser
@pytest.mark.parametrize("which", ["out", "plain"])
def test_a_page_opens_without_an_error_and_is_small(folder, identified, browser, which):
    look_at(browser, folder / which)
    count = browser.run("document.querySelectorAll('details.figures').length")
    browser.run("document.querySelectorAll('details').forEach((d) => { d.open = true; }); 0")
    browser.until(f"Bokeh.documents.length === {count} && Bokeh.documents.every((d) => d.is_idle)")
    assert browser.errors == []
    assert (folder / which / "report.html").stat().st_size < LARGEST


@needs_browser
def test_a_zoom_changes_all_axes_of_time(looked_at):
    before = {
        n: looked_at.run(f"ends(plot('{n}').x_range)") for n in ("voltage", "displacement", "error")
    }
    looked_at.drag(
        inside(looked_at, "displacement", 0.4, 0.2), inside(looked_at, "displacement", 0.6, 0.8)
    )
    looked_at.until(f"plot('voltage').x_range.start > {before['voltage'][0]}")
    after = {name: looked_at.run(f"ends(plot('{name}').x_range)") for name in before}
    low, high = before["voltage"]
    assert after["voltage"] == after["displacement"] == after["error"]
    assert 0.1 < (after["voltage"][1] - after["voltage"][0]) / (high - low) < 0.4
    # only what the axes hold is drawn, in the loop too
    looked_at.until("shown().data.t.length < 0.5 * 800")
    assert looked_at.run("Math.min(...shown().data.t)") > low
    assert looked_at.errors == []


@needs_browser
def test_the_pointer_shows_values_with_units(looked_at):
    looked_at.move(inside(looked_at, "displacement", 0.5, 0.5))
    # tooltips stand in a shadow tree of their own
    texts = """(() => {
      const all = [];
      const walk = (node) => {
        if (node.shadowRoot) walk(node.shadowRoot);
        for (const child of node.children || []) { all.push(child); walk(child); }
      };
      walk(document.body);
      const isText = (e) => !e.children.length && !["STYLE", "SCRIPT"].includes(e.tagName);
      return all.filter(isText).map((e) => e.textContent).join(" ");
    })()"""
    looked_at.until(f"/measured.*µm/s.test({texts})")
    said = looked_at.run(texts)
    for name, unit in (("time", "s"), ("voltage", "V"), ("measured", "µm"), ("error now", "µm")):
        assert re.search(rf"{name}.*?[\d.-]+ {unit}", said, re.DOTALL), said


@needs_browser
def test_before_and_now_are_shown_and_hidden_by_a_button(looked_at):
    hidden = "plot('displacement').renderers.filter((r) => !r.visible).length"
    assert looked_at.run(hidden) == 0
    looked_at.run("plot('toggle').active = [0, 2]; 0")
    looked_at.until(f"{hidden} === 2")  # the line, and its marks
    for name in ("loop", "spectrum", "error"):
        assert looked_at.run(f"plot('{name}').renderers.some((r) => !r.visible)")
    looked_at.run("plot('toggle').active = [0, 1, 2]; 0")
    looked_at.until(f"{hidden} === 0")
    assert looked_at.errors == []


@needs_browser
def test_what_is_selected_in_the_loop_is_marked_over_time_and_stays_so_when_one_zooms(looked_at):
    looked_at.run("plot('loop').toolbar.active_drag = plot('loop').toolbar.tools"
                  ".find((t) => t.type === 'BoxSelectTool'); 0")  # fmt: skip
    begin, end = inside(looked_at, "loop", 0.5, 0.05), inside(looked_at, "loop", 0.92, 0.45)
    looked_at.drag(begin, end)
    looked_at.until("shown().selected.indices.length > 10")
    picked = looked_at.run("shown().selected.indices.map((i) => shown().data.u[i])")
    others = looked_at.run("Array.from(shown().data.u).length") - len(picked)
    assert others > 10 and min(picked) > looked_at.run("Math.min(...shown().data.u)") + 30
    marks = "plot('displacement').renderers.filter((r) => r.glyph.type === 'Scatter')"
    assert looked_at.run(f"{marks}.every((r) => r.data_source === shown())")
    times = looked_at.run("shown().selected.indices.map((i) => shown().data.t[i])")
    middle = times[len(times) // 2]
    looked_at.run(f"plot('voltage').x_range.setv({{start: {middle - 0.01}, end: {middle + 0.01}}}); 0")
    looked_at.until("shown().data.t.length < 400")
    again = looked_at.run("shown().selected.indices.map((i) => shown().data.t[i])")
    assert again and set(again) <= set(times)
    assert looked_at.errors == []


@needs_browser
def test_a_million_samples_stay_fluid_and_hide_no_peak(folder, tmp_path, browser):
    out = shutil.copytree(folder / "out", tmp_path / "long")
    count, spikes = 1_000_000, (123_456, 700_001)
    time = np.arange(count) * 1e-4
    voltage = 50.0 - 50.0 * np.cos(2 * np.pi * 5.0 * time)
    measured = UM * (0.15 * voltage + 0.01 * np.random.default_rng(0).standard_normal(count))
    measured[spikes[0]] += 3 * UM
    measured[spikes[1]] -= 3 * UM
    signals = dict.fromkeys(SIGNALS, 0.0 * time) | {"voltage": voltage, "measured": measured}
    signals |= {"before": 0.15 * UM * voltage, "after": 0.15 * UM * voltage}
    write_courses(out, dict.fromkeys(ROLES, make_course(1e-4, time, **signals)))
    assert run("report", out, "--quiet") == 0
    assert (out / "report.html").stat().st_size < LARGEST
    look_at(browser, out)
    extremes = browser.run("[Math.max(...shown().data.ea), Math.min(...shown().data.ea)]")
    assert extremes == pytest.approx([3.0, -3.0], abs=0.06)
    assert browser.run("shown().data.t.length") < 20_000
    # of a zoom: the time until the next picture is drawn
    seconds = browser.run("""(async () => {
      const begin = performance.now();
      plot("voltage").x_range.setv({start: 12, end: 13});
      for (let k = 0; k < 3; k++) await new Promise(requestAnimationFrame);
      return (performance.now() - begin) / 1000;
    })()""")
    assert seconds < 2.0  # a tenth of that on an idle machine
    browser.until("Math.max(...shown().data.t) < 13.1")
    assert browser.run("Math.max(...shown().data.ea)") == pytest.approx(3.0, abs=0.06)
    assert browser.errors == []
