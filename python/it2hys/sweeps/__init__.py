"""Scenario sweeps: many cases of connected FMUs, in parallel, to one table and a report.

A scenario (`schema`) becomes a plan of cases (`planning`, `plan`); workers (`workers`, `worker`) run
them on the fast path; what is finished is kept (`store`), so that a sweep can be interrupted at any
moment; the report (`report`) is drawn from the table alone.
"""

from it2hys.sweeps.schema import SweepScenario, is_sweep, parse_sweep, read_sweep
from it2hys.sweeps.sweep import SweepOutcome, run_sweep

__all__ = [
    "SweepOutcome",
    "SweepScenario",
    "is_sweep",
    "parse_sweep",
    "read_sweep",
    "run_sweep",
]
