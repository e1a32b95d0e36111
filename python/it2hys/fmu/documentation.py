"""`documentation/` of an FMU: its origin and use, equations, timing, parameters, licence."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files

import numpy as np
from jinja2 import Environment, PackageLoader

from it2hys.fmu.model_description import IDENTIFIERS
from it2hys.model import compiled
from it2hys.model.effect import Effect
from it2hys.model.parameters import ParameterSet
from it2hys.model.stages import BEFORE_CORE, BEHIND_CORE, READING
from it2hys.model.variables import TABLE_1, Variable, load_table

#: Ticks of one loop of the picture, and the loops in it: their lower and upper ends in its range.
_TICKS = 400
_LOOPS = ((0.0, 1.0), (0.25, 0.7))


@dataclass(frozen=True)
class OriginRecord:
    """A record that a set was identified from or judged on; `row` is what a page says of it."""

    name: str
    role: str
    row: Sequence[str]


@dataclass(frozen=True)
class Origin:
    """What a parameter set was identified from.

    Parameters
    ----------
    command : str
        That made it.
    date : str
        When, as year-month-day.
    heads : sequence of str
        Of the columns of the records' rows.
    records : sequence of OriginRecord
    """

    command: str
    date: str
    heads: Sequence[str]
    records: Sequence[OriginRecord]


def documentation_files(
    model: str,
    parameters: ParameterSet,
    licence: bytes,
    origin: Origin | None = None,
    fmi: int = 2,
) -> dict[str, bytes]:
    """Return the files of `documentation/` by their path in the FMU."""
    variables = load_table().of_model(model, parameters.counts)
    page = render(
        "documentation.html",
        model=model,
        fmi=fmi,
        identifier=IDENTIFIERS[model],
        parameters=parameters,
        sample_time=parameters["sampleTime"],
        origin=origin,
        is_published=parameters.name == TABLE_1,
        before=_words(BEFORE_CORE),
        behind=_words(BEHIND_CORE),
        reading=_words(READING),
        signals=[v for v in variables if v.causality != "parameter"],
        scalars=[_row(v, parameters) for v in variables if v.causality == "parameter"],
    )
    timing = files("it2hys.fmu") / "templates" / "timing.svg"
    return {
        "documentation/index.html": page.encode(),
        "documentation/timing.svg": timing.read_bytes(),
        "documentation/loop.svg": render("loop.svg", **_loops(parameters)).encode(),
        "documentation/licenses/license.txt": licence,
    }


def render(template: str, **values: object) -> str:
    """Return a page of the package's templates, filled in."""
    environment = Environment(
        loader=PackageLoader("it2hys.fmu"), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    return environment.get_template(template).render(**values)


def _words(effects: dict[str, Effect]) -> list[str]:
    return [effect.words or name for name, effect in effects.items()]


def _row(variable: Variable, parameters: ParameterSet) -> dict:
    """Return a parameter as the FMU takes it, and beside that as people read it: lengths in µm."""
    value, shown, shown_unit = parameters[variable.name], "", ""
    if variable.type.displayUnit in ("um", "um/V"):
        shown = f"{value * 1e6:.6g}"
        shown_unit = variable.type.displayUnit.replace("u", "µ", 1)
    return {
        "name": variable.name,
        "value": str(value).lower() if isinstance(value, bool) else f"{value:.6g}",
        "unit": variable.type.unit or "",
        "shown": shown,
        "shown_unit": shown_unit,
        "text": variable.description,
    }


def _loops(parameters: ParameterSet) -> dict:
    """Return what the picture shows: the loops of the model, a large one and a small one in it."""
    low, high = parameters.voltage_range
    turns = np.arange(3 * _TICKS) / _TICKS
    loops = []
    for begin, end in _LOOPS:
        share = begin + (end - begin) * (0.5 - 0.5 * np.cos(2 * np.pi * turns))
        voltage = low + (high - low) * share
        displacement = compiled.chain_free_run(parameters, voltage)[0] * 1e6
        # the last turn alone, closed
        loops.append((voltage[-_TICKS - 1 :], displacement[-_TICKS - 1 :]))
    least, most = loops[0][1].min(), loops[0][1].max()
    points = [
        " ".join(
            f"{70 + 330 * (u - low) / (high - low):.1f},{265 - 250 * (y - least) / (most - least):.1f}"
            for u, y in zip(*pair, strict=True)
        )
        for pair in loops
    ]
    return {
        "loops": points,
        "low": (f"{low:.4g}", f"{least:.4g}"),
        "high": (f"{high:.4g}", f"{most:.4g}"),
    }
