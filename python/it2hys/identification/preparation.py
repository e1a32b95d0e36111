"""Preparation of measured records for a fit: the first part left out, noise, scaling."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from it2hys.errors import InputError
from it2hys.identification.noise import NoiseEstimate, estimate_noise
from it2hys.identification.ringing import ringing_out
from it2hys.identification.rule_coordinates import RULE_SIZE
from it2hys.identification.scaling import Scaling
from it2hys.model.variables import load_table
from it2hys.policy import COVERAGE, STARTS
from it2hys.records import Record


@dataclass(frozen=True, eq=False)
class Prepared:
    """A record prepared for a fit.

    Parameters
    ----------
    record : Record
    skip : int
        Leading samples left out.
    noise : NoiseEstimate
        In m.
    rings : bool
        Whether they are left out as the stage rings there from before the record.
    """

    record: Record
    skip: int
    noise: NoiseEstimate
    rings: bool = False

    @property
    def used(self) -> np.ndarray:
        """Mask of the samples that are fitted and judged, shape (N,)."""
        mask = ~self.record.outliers
        mask[: self.skip] = False
        return mask


def prepare(record: Record) -> Prepared:
    """Find the first part of a record that is left out, and its noise.

    Raises
    ------
    InputError
        If most of the samples are not to be trusted.
    """
    x, y, trusted = record.voltage, record.displacement, ~record.outliers
    if np.mean(trusted) < COVERAGE.trusted:
        raise InputError(
            f"record '{record.name}': {np.count_nonzero(record.outliers)} of {len(record)} samples "
            "are clipped, stuck, spikes or filled in; a record needs at least half of its "
            "displacements measured"
        )
    skip = _falling_in(x)
    noise = estimate_noise(x[skip:], y[skip:], trusted[skip:])
    # spikes and what a clipped sensor shows are no ringing
    k = np.arange(len(record))
    ringing = ringing_out(x, np.interp(k, k[trusted], y[trusted]), noise.rms)
    return Prepared(record, max(skip, ringing), noise, ringing > 0)


def _falling_in(voltage: np.ndarray) -> int:
    """Return how many samples are left out at first: a model begins at rest, a record need not."""
    in_motion = abs(voltage[1] - voltage[0]) > STARTS.in_motion * np.ptp(voltage)
    return min(STARTS.falling_in, int(STARTS.falling_in_share * len(voltage))) if in_motion else 0


def check_rule_count(rule_count: int | None) -> None:
    """Refuse a number of rules that no model can have; None stands for one to be chosen.

    Raises
    ------
    InputError
        If it is not a whole number from 1 to the largest that the FMUs take.
    """
    most = load_table().counts["rule"]["maximum"]
    whole = isinstance(rule_count, int | np.integer)
    if rule_count is None or (whole and 1 <= rule_count <= most):
        return
    raise InputError(f"the number of rules must be a whole number from 1 to {most}, not {rule_count}")


def largest_rule_count(prepared: Sequence[Prepared]) -> int:
    """Return for how many rules the records have enough samples to be fitted.

    Raises
    ------
    InputError
        If they have too few for a single rule.
    """
    samples = sum(int(np.count_nonzero(p.used)) for p in prepared)
    count = (samples // COVERAGE.samples_per_parameter - 1) // RULE_SIZE
    if count < 1:
        raise InputError(too_short(1, prepared))
    return count


def too_short(rule_count: int, prepared: Sequence[Prepared]) -> str:
    """Return a sentence on how many samples a number of rules needs."""
    samples = sum(int(np.count_nonzero(p.used)) for p in prepared)
    parameters = RULE_SIZE * rule_count + 1
    return (
        f"a model of L = {rule_count} has {parameters} parameters (6 L + 1), which need "
        f"{COVERAGE.samples_per_parameter * parameters} samples; the training records have "
        f"{samples} usable"
    )


def check_sample_times(records: Sequence[Record]) -> float:
    """Return the common sample time, s.

    Raises
    ------
    InputError
        If the records differ: (10) holds for one sample time.
    """
    first = records[0]
    for record in records[1:]:
        if not np.isclose(record.sample_time, first.sample_time, rtol=1e-4):
            raise InputError(
                f"record '{record.name}' is sampled every {record.sample_time:g} s, "
                f"'{first.name}' every {first.sample_time:g} s: resample one of them"
            )
    return first.sample_time


def data_scaling(prepared: Sequence[Prepared]) -> Scaling:
    """Return the scaling by the range of the used samples.

    Raises
    ------
    InputError
        If the voltage or the displacement is the same in all of them.
    """
    displacement = np.concatenate([p.record.displacement[p.used] for p in prepared])
    voltage = np.concatenate([p.record.voltage[p.used] for p in prepared])
    for quantity, values in (("displacement", displacement), ("voltage", voltage)):
        if np.ptp(values) == 0.0:
            names = ", ".join(f"'{p.record.name}'" for p in prepared)
            raise InputError(
                f"record{'s' * (len(prepared) > 1)} {names}: the {quantity} is {values[0]:g} in all "
                "usable samples after the start of the record; give a record in which it varies"
            )
    return Scaling.of_data(displacement, voltage)
