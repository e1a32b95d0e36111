"""Scenario sweeps: many cases of connected FMUs, in parallel, to one table and a report.

A scenario (`schema`) becomes a plan of cases (`cases`, `plan`); workers (`pool`, `worker`) run
them on the fast path; what is finished is kept (`store`), so that a sweep can be interrupted at any
moment; the report (`report`) is drawn from the table alone.
"""

from typing import TYPE_CHECKING

from it2hys.sweeps.schema import SweepScenario, is_sweep, parse_sweep, read_sweep

if TYPE_CHECKING:
    from it2hys.sweeps.sweep import SweepOutcome, run_sweep

__all__ = [
    "SweepOutcome",
    "SweepScenario",
    "is_sweep",
    "parse_sweep",
    "read_sweep",
    "run_sweep",
]


def __getattr__(name: str) -> object:
    """Load what packages FMUs when it is asked for: workers get theirs in a plan."""
    if name not in ("SweepOutcome", "run_sweep"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from it2hys.sweeps import sweep

    return getattr(sweep, name)
