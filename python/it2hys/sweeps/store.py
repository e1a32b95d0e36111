"""Where a sweep keeps what it has: parts that appear whole or not at all, and one table in the end.

`parts/` holds a file for every finished chunk of cases. A sweep that is interrupted, at any moment and
in any way, finds there what it need not run again. When all are there they become `results.parquet`, by
one rename, and only then are they removed. Parts are streams of Arrow's: as Parquet, a hundred rows
would take seven times as long to write.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from it2hys.errors import InputError
from it2hys.support.files import make_directory, write_atomically
from it2hys.sweeps.plan import Axis, Plan

if TYPE_CHECKING:
    import polars as pl

RESULTS = "results.parquet"
PARTS = "parts"
KEY = "it2hys"
#: Room beside the estimate, bytes: reports and figures.
ROOM = 20_000_000
#: Rows that are read together to get at one of them, bytes.
ROW_GROUP = 16_000_000


class Store:
    """The files of a sweep in its directory.

    Parameters
    ----------
    directory : path
        Made by `begin` if it does not exist.
    plan : Plan
        What is run.
    restart : bool
        Discard what the directory holds.

    Raises
    ------
    InputError
        If the directory holds another sweep's results, or its disk is too full.
    """

    def __init__(self, directory: str | Path, plan: Plan, restart: bool = False) -> None:
        self.directory, self.plan = Path(directory), plan
        self.results = self.directory / RESULTS
        self._parts = self.directory / PARTS
        self._manifest = self._parts / "sweep.json"
        self._restart = restart
        if not restart:
            self._check_owner()
        if not self.complete:
            self._check_room()

    def begin(self) -> None:
        """Make the directory ready for parts; what another sweep has left is discarded here."""
        if self._restart:
            self.results.unlink(missing_ok=True)
            shutil.rmtree(self._parts, ignore_errors=True)
        make_directory(self._parts)
        owner = json.dumps({"fingerprint": self.plan.fingerprint}).encode()
        write_atomically(self._manifest, owner)
        for path in self._parts.glob(".*"):  # what an interrupted write has left
            path.unlink(missing_ok=True)

    def _check_owner(self) -> None:
        found = None
        if self.results.exists():
            found = read_metadata(self.results)["fingerprint"]
        elif self._manifest.exists():
            found = json.loads(self._manifest.read_text(encoding="utf-8"))["fingerprint"]
        if found not in (None, self.plan.fingerprint):
            raise InputError(
                f"{self.directory}: holds results of another sweep, or of this one before its scenario "
                "was changed; choose another directory, or discard them with --restart"
            )

    @property
    def complete(self) -> bool:
        """Whether the table is there."""
        return self.results.exists() and not self._restart

    def _check_room(self) -> None:
        # parts and table are both there for a moment
        needed = 2 * self.plan.cases * self._row_size() + ROOM
        place = self.directory.absolute()
        while not place.exists():
            place = place.parent
        free = shutil.disk_usage(place).free
        if free < needed:
            raise InputError(
                f"{self.directory}: {free / 1e6:.0f} MB are free, {needed / 1e6:.0f} MB may be needed; "
                "make room, keep fewer outputs or raise keep_every"
            )

    def _row_size(self) -> float:
        """Return what a row of the table may take, bytes."""
        plan = self.plan
        kept = len(plan.keep) * plan.lengths().mean() / plan.keep_every
        return 8 * (len(plan.axes) + len(plan.metrics) + kept) + 200

    def _part(self, chunk: int) -> Path:
        return self._parts / f"{chunk:06d}.arrow"

    def done(self, chunks: Collection[int]) -> set[int]:
        """Return the chunks that are finished."""
        return {chunk for chunk in chunks if self._part(chunk).exists()}

    def write(self, chunk: int, content: bytes) -> None:
        """Keep a finished chunk."""
        write_atomically(self._part(chunk), content)

    def finish(self, chunks: int) -> None:
        """Make the table of all parts, then remove them."""
        import polars as pl

        temporary = self._parts / ".results.parquet"
        parts = [self._part(chunk) for chunk in range(chunks)]
        try:
            _scan(parts).sink_parquet(
                temporary,
                row_group_size=int(np.clip(ROW_GROUP // self._row_size(), 1, 100_000)),
                metadata={KEY: json.dumps(metadata(self.plan))},
            )
            count = pl.scan_parquet(temporary).select(pl.len()).collect().item()
            if count != self.plan.cases:
                raise InputError(
                    f"{self._parts}: holds {count} of {self.plan.cases} cases; --restart begins again"
                )
            os.replace(temporary, self.results)
        except (OSError, pl.exceptions.PolarsError) as error:
            temporary.unlink(missing_ok=True)
            reason = str(error).partition(" (os error")[0]  # the rest names the temporary file
            raise InputError(f"{self.results}: cannot be written: {reason}") from None
        self._restart = False
        self.tidy()

    def tidy(self) -> None:
        """Remove the parts of a table that is there."""
        shutil.rmtree(self._parts, ignore_errors=True)


def _scan(parts: Sequence[Path]) -> pl.LazyFrame:
    """Return the rows of all parts, read part by part."""
    import polars as pl
    from polars.io.plugins import register_io_source

    def read(
        columns: list[str] | None, predicate: pl.Expr | None, rows: int | None, _size: int | None
    ) -> Iterator[pl.DataFrame]:
        yield from map(pl.read_ipc_stream, parts)

    return register_io_source(read, schema=pl.read_ipc_stream(parts[0]).schema)


def metadata(plan: Plan) -> dict:
    """Return what the table carries with it: all that a report needs beside the rows."""
    return {
        "fingerprint": plan.fingerprint,
        "name": plan.name,
        "title": plan.title,
        "text": plan.text,
        "cases": plan.cases,
        "step": plan.step,
        "keep_every": plan.keep_every,
        "variants": [setup.name for setup in plan.setups],
        "axes": [_axis(axis, values) for axis, values in zip(plan.axes, plan.matrix.T, strict=True)],
        "metrics": [
            {"name": m.name, "kind": m.kind, "unit": unit, "of": m.of, "against": m.against}
            for m, unit in zip(plan.metrics, plan.metric_units, strict=True)
        ],
        "keep": [
            {"name": name, "unit": unit} for name, unit in zip(plan.keep, plan.keep_units, strict=True)
        ],
        "figures": [dict(figure) for figure in plan.figures],
    }


def _axis(axis: Axis, values: np.ndarray) -> dict:
    """Return what a report needs to know of an axis; no logarithm of what is not positive."""
    scale = axis.scale if values.min() > 0.0 else "linear"
    return {"name": axis.name, "unit": axis.unit, "method": axis.method, "scale": scale}


def read_metadata(path: Path) -> dict:
    """Return what a table carries with it.

    Raises
    ------
    InputError
        If the file is no table of a sweep.
    """
    import polars as pl

    try:
        return json.loads(pl.read_parquet_metadata(path)[KEY])
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (KeyError, OSError, ValueError, pl.exceptions.PolarsError):
        raise InputError(f"{path}: no table of `it2hys sweep`") from None
