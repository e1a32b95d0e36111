"""Feedforward on the simulated stand: a reference tracked by inverse FMUs and by straight lines."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from it2hys.cosimulation.simulation import track
from it2hys.experiments.scenario import SAMPLE_TIME, Paper, Scenario
from it2hys.fmu.packaging import package
from it2hys.model.parameters import ParameterSet
from it2hys.records.figures_of_merit import Errors, errors
from it2hys.reports import figures
from it2hys.reports.page import NONE, Picture, Section, Table
from it2hys.reports.verdict import feedforward_verdict, percent
from it2hys.support.progress import Progress

UM = 1e6
#: Travel over voltage range by the data sheet, known without any measurement, m/V.
DATA_SHEET_SLOPE = 16e-6 / 105.0


@dataclass(frozen=True, eq=False)
class Course:
    """One way of driving the stand: voltage (V), displacement read (m), and its tracking errors."""

    voltage: np.ndarray
    displacement: np.ndarray
    errors: Errors


@dataclass(frozen=True, eq=False)
class Feedforward:
    """How a reference was tracked on the stand; arrays leave out the lead-in.

    Parameters
    ----------
    signal : str
        Name of the reference.
    lead_in : float
        Seconds at the start that the errors leave out.
    time, reference : ndarray, shape (N,)
        s and m.
    inverse : dict of str to Course
        By inverse FMUs, by the name of their model.
    proportional, none : Course
        By a straight line fitted to the training records, and by the data sheet's.
    with_plant : Errors
        Of the last of the inverse FMUs with the plant FMU of the same set.
    paper : Paper
        Published figures.
    """

    signal: str
    lead_in: float
    time: np.ndarray
    reference: np.ndarray
    inverse: dict[str, Course]
    proportional: Course
    none: Course
    with_plant: Errors
    paper: Paper

    @property
    def final(self) -> Course:
        """By the last of the inverse FMUs."""
        return list(self.inverse.values())[-1]


def track_on_stand(
    scenario: Scenario,
    models: Mapping[str, ParameterSet],
    line: tuple[float, float],
    progress: Progress,
) -> Feedforward:
    """Track a scenario's reference on its stand, which begins at rest at 0 V, in every way.

    Parameters
    ----------
    scenario : Scenario
        With a `tracking`.
    models : mapping of str to ParameterSet
        By name. Each is packaged; its inverse FMU begins as its set says.
    line : (float, float)
        Slope (m/V) and offset (m) of proportional feedforward.
    progress : callable
        Told the share done and what is being done.
    """
    entry = scenario.tracking
    reference = entry.values()
    kept = slice(round(entry.lead_in / SAMPLE_TIME), None)

    def course(voltage: np.ndarray, y: np.ndarray) -> Course:
        return Course(voltage[kept], y[kept], errors(reference[kept], y[kept]))

    def drive(voltage: np.ndarray) -> Course:
        return course(voltage, scenario.stand.run(voltage, seed=scenario.seed).measured)

    inverse = {}
    for i, (name, parameters) in enumerate(models.items()):
        progress(i / len(models), f"feedforward on the stand: {name}")
        with tempfile.TemporaryDirectory(prefix="it2hys-") as folder:
            package(parameters, folder)
            fmu = Path(folder, "IT2Inverse.fmu")
            driven = track(fmu, scenario.stand.start(scenario.seed).step, reference)
            model = track(fmu, Path(folder, "IT2Plant.fmu"), reference)
        inverse[name] = course(driven["voltage"], driven["displacement"])
    slope, offset = line
    return Feedforward(
        signal=entry.signal,
        lead_in=entry.lead_in,
        time=entry.time[kept],
        reference=reference[kept],
        inverse=inverse,
        proportional=drive((reference - offset) / slope),
        none=drive(reference / DATA_SHEET_SLOPE),
        with_plant=errors(reference[kept], model["displacement"][kept]),
        paper=entry.paper,
    )


def conclusion(result: Feedforward, advice: str) -> list[str]:
    """Return in words how the reference was tracked; first if the inverse is worse than none.

    Parameters
    ----------
    result : Feedforward
    advice : str
        What to do then, as a sentence; empty if it has been said.
    """
    ours = result.final.errors
    *before, _ = result.inverse.items()
    others = [(f"the {name}", course) for name, course in before]
    others += [("proportional feedforward", result.proportional), ("none", result.none)]
    (first, course), *rest = others
    paper = result.paper.e_mr_percent
    text = (
        f"Driven by the inverse FMU, the stage follows its reference to within {percent(ours.e_mr)} of "
        f"its range (largest error, e_mr; {UM * ours.e_rms:.2g} µm rms). With {first} it is "
        f"{percent(course.errors.e_mr)}"
        + "".join(f", with {name} {percent(c.errors.e_mr)}" for name, c in rest)
        + ("." if paper is None else f"; the paper published {paper:g} %.")
    )
    return [*feedforward_verdict(ours, result.none.errors, advice), text]


def feedforward_json(result: Feedforward) -> dict:
    """Return the tracking errors as `report.json` has them."""
    names = ("before", "after") if len(result.inverse) == 2 else ("inverse",)
    courses = dict(zip(names, result.inverse.values(), strict=True))
    courses |= {"proportional": result.proportional, "none": result.none}
    return {
        name: {"e_mr_percent": 100 * c.errors.e_mr, "e_rms_um": UM * c.errors.e_rms}
        for name, c in courses.items()
    }


def feedforward_table(result: Feedforward) -> Table:
    """Return the tracking errors of every way, the first inverse beside the published figures."""
    published = [(result.paper.e_mr_percent, result.paper.e_rms_um)]
    published += [(None, None)] * (len(result.inverse) - 1)
    published += [(result.paper.proportional_e_mr_percent, None), (None, None)]
    courses = {
        **{f"inverse FMU, {name}": course for name, course in result.inverse.items()},
        "proportional": result.proportional,
        "none (data sheet)": result.none,
    }
    rows = [
        [
            name,
            *(NONE if figure is None else f"{figure:g}" for figure in paper),
            f"{100 * course.errors.e_mr:.3g}", f"{UM * course.errors.e_rms:.3g}",
        ]
        for (name, course), paper in zip(courses.items(), published, strict=True)
    ]  # fmt: skip
    return Table(
        ["feedforward", "paper e_mr %", "paper e_rms µm", "e_mr %", "e_rms µm"],
        rows,
        f"Tracking of {result.signal} on the stand",
    )


def feedforward_section(result: Feedforward) -> Section:
    """Return how the stand tracks the reference, over time."""
    text = [
        "The reference goes through IT2Inverse.fmu, and its voltage drives the simulated stand. "
        "Proportional feedforward divides by the slope of a straight line fitted to the training "
        "records; without any identification one divides by the data sheet's. Errors leave out the "
        f"first {result.lead_in:g} s. With IT2Plant.fmu in place of the stand e_mr is "
        f"{100 * result.with_plant.e_mr:.2g} %: the two FMUs agree, and the errors above are "
        "those of the model of the stand."
    ]
    courses = {name: c.displacement for name, c in reversed(result.inverse.items())}
    if len(courses) == 1:
        courses["proportional"] = result.proportional.displacement
    picture = Picture(
        "tracking_stand",
        figures.tracking(result.time, result.reference, courses, result.final.voltage, "Feedforward"),
        "Reference, displacement, tracking error and voltage of the last inverse FMU (compare the "
        "paper's Figure 7).",
    )
    return Section("Feedforward on the stand", text, [feedforward_table(result)], [picture])
