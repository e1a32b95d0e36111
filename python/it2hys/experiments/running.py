"""Running a scenario: records from the stand, a model, tracking, and a report beside the paper."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from it2hys.designs.designing import design
from it2hys.designs.hypotheses import question_of_report
from it2hys.diagnosis import RULES, Diagnosis, diagnose
from it2hys.experiments.estimator_comparison import compare_estimators
from it2hys.experiments.feedforward import (
    Feedforward,
    conclusion,
    feedforward_json,
    feedforward_section,
    track_on_stand,
)
from it2hys.experiments.scenario import NextEntry, Paper, RecordEntry, Scenario, read_scenario
from it2hys.experiments.scenario_files import find_scenario
from it2hys.identification import Identification, Judgement, Options, identify
from it2hys.identification.evaluation import as_identification, evaluate
from it2hys.model.parameters import ParameterSet, table_1
from it2hys.records import Record, write_record
from it2hys.records.figures_of_merit import Errors
from it2hys.reports.answers import ROLES, advice, found, verdict
from it2hys.reports.design_report import design_json, write_design
from it2hys.reports.figures import Compared
from it2hys.reports.page import NONE, Answer, Section, Table
from it2hys.reports.pair_report import write_report
from it2hys.reports.provenance import Provenance
from it2hys.reports.summary import PAPER, Result, model_names, summary
from it2hys.reports.verdict import Judged, percent, straight_line, straight_line_errors
from it2hys.support.files import check_directory, gathered, make_directory
from it2hys.support.processes import check_workers
from it2hys.support.progress import Progress, part, silent

REASON = (
    "The published figures were measured on the paper's rig, ours on the simulated stand. The paper "
    "does not say whether its errors are one step ahead or free run. One step ahead the model is "
    "given the measured y(k-1), which is nearly the answer. In free run it has the voltage and its "
    "own past output alone: one state without a memory of turning points, whose loop is phase lag and "
    "grows with frequency, where the stand's loop hardly does. Hence the gap between the two."
)
UM = 1e6
#: Heading of the scenario's result on the page.
_QUESTION = "What the scenario shows"
#: Name of the model before a diagnosis that follows another one.
FIRST = "first model"
#: Folder for the records of a run, as CSV.
RECORDS = "records"
#: Folder for a record that the run designed.
DESIGNS = "next"


@dataclass(frozen=True)
class Outcome:
    """What a scenario leaves.

    Parameters
    ----------
    tables : list of Table
        For the terminal.
    conclusion : list of str
        What they say, in sentences.
    report : Path
    command : str
        Of `it2hys`, for what the run did with records in files.
    records : Path
        Where those of the run are.
    """

    tables: list[Table]
    conclusion: list[str]
    report: Path
    command: str
    records: Path


def run_scenario(
    name: str, directory: Path | None = None, progress: Progress = silent, workers: int = 1
) -> Outcome:
    """Run a scenario and write its results.

    Parameters
    ----------
    name : str
        Name or path of the scenario.
    directory : path, optional
        `out/NAME` by default.
    progress : callable
        Told the share done and what is being done.
    workers : int
        Processes that share the fits of a diagnosis. The result does not depend on it.

    Raises
    ------
    InputError
        If the scenario is not usable.
    """
    file = find_scenario(name)
    scenario = read_scenario(file)
    directory = Path(directory or Path("out") / scenario.name)
    check_workers(workers)
    check_directory(directory)
    with gathered(directory) as folder:
        outcome = _Run(scenario, file, folder, progress, workers).run()
    return replace(
        outcome,
        report=directory / outcome.report.name,
        records=directory / outcome.records.name,
    )


class _Run:
    """One run of a scenario: what its parts hand on to each other."""

    def __init__(
        self, scenario: Scenario, file: Path, directory: Path, progress: Progress, workers: int
    ):
        self._scenario, self._file, self._directory = scenario, file, directory
        self._progress, self._workers = progress, workers
        self._records: list[Record] = []
        self._entries: list[RecordEntry] = list(scenario.records)
        self._told: list[str] = []
        self._introduction = [scenario.text] if scenario.text else []

    def run(self) -> Outcome:
        """Measure, model, track and report."""
        scenario = self._scenario
        for i, entry in enumerate(scenario.records):
            self._progress(0.0, f"measuring on the simulated stand: {entry.name}")
            voltage = entry.values()
            self._records.append(scenario.stand.record(voltage, entry.name, seed=scenario.seed + i))
        model = {
            "table 1": self._with_table_1,
            "identified": self._with_identification,
            "diagnosed": self._with_diagnosis,
        }[scenario.model]
        folder = make_directory(self._directory / RECORDS)
        self._records = [_written(record, folder) for record in self._records]
        tables, texts, report = model()
        return Outcome(tables, texts, report, _command(scenario), folder)

    def _with_table_1(self) -> tuple[list[Table], list[str], Path]:
        parameters = table_1()
        evaluated = as_identification(parameters, evaluate(parameters, self._records))
        return self._without_effects(evaluated, "Table 1")

    def _with_identification(self) -> tuple[list[Table], list[str], Path]:
        scenario = self._scenario
        roles = self._by_role()
        identification = identify(
            *roles, scenario.rules, Options(seed=scenario.seed), part(self._progress, 0.0, 0.4)
        )
        compared = []
        if scenario.estimators:
            progress = part(self._progress, 0.4, 0.8)
            compared.append(
                compare_estimators(roles[0], scenario.rules or RULES, scenario.seed, progress)
            )
        return self._without_effects(identification, "identified model", compared)

    def _without_effects(
        self, found: Identification, name: str, more: Sequence[Section] = ()
    ) -> tuple[list[Table], list[str], Path]:
        """Track and report with a model that has no effects."""
        scenario = self._scenario
        tracked = self._track({name: found.parameters}, found.records)
        report = summary(found, self._records)
        first = verdict(report)
        texts = _tracking_texts(tracked, "" if first else advice(report))
        beside = comparison(scenario.records, found.records)
        sections = [beside, *_tracking_sections(tracked), *more]
        page = self._write(found, Answer(_QUESTION, texts, None, self._introduction), sections)
        tables = [table for section in sections for table in section.tables]
        return tables, [*first, *texts], page

    def _with_diagnosis(self) -> tuple[list[Table], list[str], Path]:
        scenario = self._scenario
        share = 0.35 if scenario.next else 0.8
        diagnosis = self._diagnose(None, part(self._progress, 0.0, share))
        start, promised = PAPER, None
        if scenario.next:
            promised = self._measure_next(scenario.next, diagnosis)
            start = FIRST
            diagnosis = self._diagnose(diagnosis.parameters, part(self._progress, 0.5, 0.8))
        names = model_names(diagnosis, start)
        models = dict(zip(names.values(), (diagnosis.base, diagnosis.parameters), strict=True))
        tracked = self._track(models, diagnosis.after)
        lines = straight_line_errors(self._records, diagnosis.after)
        report = summary(diagnosis, self._records, start)
        first = verdict(report)
        texts = [*self._told, *_tracking_texts(tracked, "" if first else advice(report))]
        table = before_and_after(self._entries, diagnosis, lines, tracked, start)
        page = self._write(
            diagnosis,
            Answer(_QUESTION, texts, table, self._introduction),
            _tracking_sections(tracked),
            _drawn(tracked),
            {"tracking": feedforward_json(tracked)} if tracked else {},
            start,
            promised,
        )
        return [table], [*first, *texts, *found(report)], page

    def _diagnose(self, model: ParameterSet | None, progress: Progress) -> Diagnosis:
        """Diagnose the records there are, from the paper's model or a given one."""
        return diagnose(
            *self._by_role(),
            model,
            rules=self._scenario.rules or RULES,
            options=Options(seed=self._scenario.seed),
            progress=progress,
            workers=self._workers,
        )

    def _measure_next(self, entry: NextEntry, first: Diagnosis) -> tuple[dict, np.ndarray]:
        """Design a record from what a diagnosis leaves open, and measure it instead of those fitted."""
        scenario, folder = self._scenario, self._directory / RECORDS
        question = question_of_report(summary(first, self._records), lambda: first.parameters)
        found = design(
            question, entry.wanted(), seed=scenario.seed, progress=part(self._progress, 0.35, 0.5)
        )
        write_design(found, self._directory / DESIGNS)
        seed = scenario.seed + len(scenario.records)
        record = _written(scenario.stand.record(found.voltage, entry.name, seed=seed), folder)
        kept = [
            pair for pair in zip(self._records, self._entries, strict=True) if pair[1].role != "train"
        ]
        self._records = [record, *(r for r, _ in kept)]
        new = RecordEntry.model_construct(name=entry.name, role="train", paper=Paper())
        self._entries = [new, *(e for _, e in kept)]
        open_ = " and ".join(e for group in first.indistinguishable for e in group)
        named = " and ".join(first.effects) or "no effect"
        self._told = [
            f"On the first record the diagnosis named {named}, and could not decide between {open_}. "
            + " ".join(found.sentences)
        ]
        return design_json(found, Provenance(), "parameters.ssv"), found.voltage

    def _write(
        self,
        result: Result,
        lead: Answer,
        sections: Sequence[Section],
        tracked: Compared | None = None,
        more: Mapping[str, object] | None = None,
        start: str = PAPER,
        promised: tuple[Mapping, np.ndarray] | None = None,
    ) -> Path:
        """Write the report, with what the scenario shows at its top."""
        scenario = self._scenario
        return write_report(
            result,
            self._records,
            self._directory,
            scenario.title,
            Provenance(f"it2hys run {scenario.name}", scenario.seed, (self._file,)),
            lead,
            tracked,
            [*sections, own_records(scenario)],
            more,
            start,
            part(self._progress, 0.85, 1.0),
            promised,
        )

    def _by_role(self) -> list[list[Record]]:
        """Return the training, validation and test records."""
        pairs = list(zip(self._records, self._entries, strict=True))
        return [[record for record, entry in pairs if entry.role == role] for role in ROLES]

    def _track(self, models: dict[str, ParameterSet], results: Sequence[Judged]) -> Feedforward | None:
        """Track the reference if there is one."""
        if not self._scenario.tracking:
            return None
        line = straight_line(self._records, results)
        return track_on_stand(self._scenario, models, line, part(self._progress, 0.8, 0.85))


def _written(record: Record, folder: Path) -> Record:
    """Write a record as CSV, and return it with its file."""
    path = folder / f"{record.name}.csv"
    write_record(path, record)
    return replace(record, path=path)


def _tracking_texts(tracked: Feedforward | None, advice: str) -> list[str]:
    return conclusion(tracked, advice) if tracked else []


def _tracking_sections(tracked: Feedforward | None) -> list[Section]:
    return [feedforward_section(tracked)] if tracked else []


def _drawn(tracked: Feedforward | None) -> Compared | None:
    if not tracked:
        return None
    before, after = tracked.inverse.values()
    title = f"Tracking error: {percent(before.errors.e_mr)} → {percent(after.errors.e_mr)}"
    courses = (after.voltage, tracked.reference, before.displacement, after.displacement)
    return Compared(title, tracked.time, *courses)


def _command(scenario: Scenario) -> str:
    verb = "diagnose" if scenario.model == "diagnosed" else "identify"
    return f"{verb} TRAIN.csv --test TEST.csv -o out/mystage"


def own_records(scenario: Scenario) -> Section:
    """Return what to do with one's own records."""
    text = [
        "A record is a CSV with units in its header; those of this run are in the folder "
        f"{RECORDS} beside this page. The same with your own records:"
    ]
    return Section("Your own records", text, commands=[f"it2hys {_command(scenario)}"])


def before_and_after(
    entries: Sequence[RecordEntry],
    diagnosis: Diagnosis,
    lines: Sequence[Errors],
    tracked: Feedforward | None,
    start: str = PAPER,
) -> Table:
    """Return what a diagnosis brought, beside the published figures and what one has without it.

    Parameters
    ----------
    entries : sequence of RecordEntry
        In the order of `diagnosis.after`.
    diagnosis : Diagnosis
    lines : sequence of Errors
        Of a straight line on the records.
    tracked : Feedforward or None
    start : str
        What the model before is called.
    """
    rows = _tracking_rows(tracked) if tracked else []
    for entry, before, after, line in zip(
        entries, diagnosis.before, diagnosis.after, lines, strict=True
    ):
        if entry.role != "train":
            published = entry.paper.e_mr_percent
            values = (100 * before.e_mr, 100 * after.e_mr, published, 100 * line.e_mr, None)
            rows.append([f"free run of {entry.name}, e_mr %", *(_figure(v, 2) for v in values)])
    return Table(
        ["", *model_names(diagnosis, start).values(), "published", "straight line", "none"],
        rows,
        "Straight line: as model and as proportional feedforward. None: feedforward by the data sheet.",
    )


def _tracking_rows(tracked: Feedforward) -> list[list[str]]:
    before, after = (course.errors for course in tracked.inverse.values())
    line, none, paper = tracked.proportional.errors, tracked.none.errors, tracked.paper
    e_mr = [100 * before.e_mr, 100 * after.e_mr, paper.e_mr_percent, 100 * line.e_mr, 100 * none.e_mr]
    e_rms = [UM * before.e_rms, UM * after.e_rms, paper.e_rms_um, UM * line.e_rms, UM * none.e_rms]
    return [
        ["tracking on the stand, e_mr %", *(_figure(value, 2) for value in e_mr)],
        ["tracking on the stand, e_rms µm", *(_figure(value, 3) for value in e_rms)],
    ]


def comparison(entries: Sequence[RecordEntry], results: Sequence[Judgement]) -> Section:
    """Set the model errors beside the paper's figures."""
    rows = [
        [
            entry.name, ROLES[entry.role],
            _figure(entry.paper.e_mr_percent), _figure(entry.paper.e_rms_um),
            f"{100 * result.one_step.e_mr:.2f}", f"{UM * result.one_step.e_rms:.4f}",
            f"{100 * result.e_mr:.2f}", f"{UM * result.e_rms:.4f}",
            f"{UM * result.noise:.4f}",
        ]
        for entry, result in zip(entries, results, strict=True)
    ]  # fmt: skip
    table = Table(
        [
            "record", "role", "paper e_mr %", "paper e_rms µm",
            "one-step e_mr %", "one-step e_rms µm", "free-run e_mr %", "free-run e_rms µm",
            "noise µm",
        ],
        rows,
        "Model errors on the simulated stand, beside the published figures",
    )  # fmt: skip
    return Section("Beside the published figures", [REASON], [table])


def _figure(value: float | None, digits: int | None = None) -> str:
    if value is None:
        return NONE
    return f"{value:g}" if digits is None else f"{value:.{digits}f}"
