"""Results of the API's functions, which a notebook shows as a table and a figure."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from html import escape
from typing import TYPE_CHECKING

from it2hys.designs.designing import Design
from it2hys.diagnosis import Diagnosis
from it2hys.errors import InputError
from it2hys.identification import Fitted, Identification, Judgement
from it2hys.records import Record
from it2hys.support.keys import known_names
from it2hys.support.numerals import counted

if TYPE_CHECKING:
    import polars as pl
    from matplotlib.figure import Figure

_UM = 1e6


@dataclass(frozen=True, eq=False, kw_only=True)
class _Shown(Fitted):
    """A model, with the records that it was made from.

    Parameters
    ----------
    measured : tuple of Record
        In the order of `records`, which says how the model does on them.
    """

    measured: tuple[Record, ...] = ()

    def _models(self) -> dict[str, tuple[Judgement, ...]]:
        """Return how models do on the records, by what they are called."""
        return {"model": self.records}

    def to_frame(self) -> pl.DataFrame:
        """Return the errors of every record, before and after a diagnosis, with units in the names."""
        return _frame(self._models())

    def plot(self, record: str | int = 0) -> Figure:
        """Draw the loop of a record, measured and of the model, before and after a diagnosis.

        Parameters
        ----------
        record : str or int
            Its name, or its place in `records`.

        Raises
        ------
        InputError
            If there is no such record.
        """
        return _loop(self.measured, dict(reversed(self._models().items())), record)


@dataclass(frozen=True, eq=False, kw_only=True)
class IdentifiedModel(_Shown, Identification):
    """An identification, with the records that it was made from."""

    def _repr_html_(self) -> str:
        rules = self.parameters.counts["rule"]
        return _html(f"Identified model, {counted(rules, 'rule')}", self.to_frame(), self.plot())


@dataclass(frozen=True, eq=False, kw_only=True)
class DiagnosedModel(_Shown, Diagnosis):
    """A diagnosis, with the records that it was made from."""

    def _models(self) -> dict[str, tuple[Judgement, ...]]:
        return {"before": self.before, "after": self.records}

    def _repr_html_(self) -> str:
        found = ", ".join(self.effects) or "no effect"
        return _html(f"Diagnosis: {found} found", self.to_frame(), self.plot())


@dataclass(frozen=True, eq=False)
class DesignedRecord(Design):
    """A designed record, and the decision that it promises."""

    def to_frame(self) -> pl.DataFrame:
        """Return the voltage to play as a data frame: time_s and voltage_V."""
        import polars as pl

        return pl.DataFrame({"time_s": self.time, "voltage_V": self.voltage})

    def plot(self) -> Figure:
        """Draw the voltage, its spectrum, what the models predict for it, and what is left of that."""
        from it2hys.reports.design_report import drawn

        return drawn(self)

    def _repr_html_(self) -> str:
        return _html(" ".join(self.sentences), self.to_frame(), self.plot())


def designed(result: Design) -> DesignedRecord:
    """Return a design that shows itself."""
    return DesignedRecord(**_values(result))


def identified(result: Identification, records: Sequence[Record]) -> IdentifiedModel:
    """Return an identification with its records."""
    return IdentifiedModel(**_values(result), measured=tuple(records))


def diagnosed(result: Diagnosis, records: Sequence[Record]) -> DiagnosedModel:
    """Return a diagnosis with its records."""
    return DiagnosedModel(**_values(result), measured=tuple(records))


def _values(result: Fitted | Design) -> dict:
    return {field.name: getattr(result, field.name) for field in fields(result)}


def _frame(models: Mapping[str, Sequence[Judgement]]) -> pl.DataFrame:
    import polars as pl

    rows = [
        {
            **({"model": name} if len(models) > 1 else {}),
            "record": j.name,
            "role": j.role,
            "e_rms_um": j.e_rms * _UM,
            "e_mr_percent": 100 * j.e_mr,
            "noise_um": j.noise * _UM,
            "cold_start_e_rms_um": j.cold_start * _UM,
            "inverse_e_rms_V": j.inverse.e_rms,
            "inverse_e_rms_um": j.inverse.e_displacement * _UM,
        }
        for name, judgements in models.items()
        for j in judgements
    ]
    return pl.DataFrame(rows)


def _loop(
    measured: Sequence[Record], models: Mapping[str, Sequence[Judgement]], record: str | int
) -> Figure:
    from it2hys.reports.figures import hysteresis_loop

    names = [r.name for r in measured]
    if isinstance(record, str):
        if record not in names:
            raise InputError(f"no record {record!r}; {known_names(record, names)}")
        record = names.index(record)
    if not -len(names) <= record < len(names):
        raise InputError(f"no record {record}; there are {len(names)}")
    runs = {name: judgements[record].y for name, judgements in models.items()}
    shown = measured[record]
    return hysteresis_loop(shown.voltage, shown.displacement, runs, shown.name)


def _html(title: str, frame: pl.DataFrame, figure: Figure) -> str:
    """Return what a notebook shows: a title, the errors, a loop."""
    from it2hys.reports.figures import png

    image = b64encode(png(figure)).decode()
    picture = f'<img style="max-width:480px" alt="loop" src="data:image/png;base64,{image}">'
    return f"<p><b>{escape(title)}</b></p>{frame._repr_html_()}{picture}"
