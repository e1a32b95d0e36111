"""The errors of a given model on records: only the start of each record is fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from it2hys.identification.criterion import Model
from it2hys.identification.effect_coordinates import by_record
from it2hys.identification.judgement import Judgement, judge_records
from it2hys.identification.preparation import check_sample_times, data_scaling, prepare
from it2hys.identification.result import Identification
from it2hys.identification.starts import Starts
from it2hys.identification.traces import extent_of, to_trace
from it2hys.model.chain import active_effects
from it2hys.model.parameters import ParameterSet
from it2hys.model.variables import load_table
from it2hys.records import Record


def evaluate(parameters: ParameterSet, records: Sequence[Record]) -> tuple[Judgement, ...]:
    """Run a model with all its effects on records, in free run and one step ahead.

    Parameters
    ----------
    parameters : ParameterSet
        The model.
    records : sequence of Record
        All at one sample time.

    Returns
    -------
    tuple of Judgement
        With the role "test".

    Raises
    ------
    InputError
        If the sample times differ.
    """
    check_sample_times(records)
    prepared = [prepare(record) for record in records]
    traces = [to_trace(p, "test", False) for p in prepared]
    effects, known = active_effects(parameters), load_table().parameters()
    own = {
        name: np.full(len(traces), parameters[name])
        for name in by_record()
        if known[name].effect in (None, *effects)
    }
    given = Model(dict(parameters), tuple(effects), np.zeros(len(traces)), own)
    starts = Starts(traces, data_scaling(prepared), extent_of(records))
    begun = starts.fit_own(given, traces)
    return judge_records(starts, begun, parameters, [starts.with_lead_in(begun, t) for t in traces])


def as_identification(parameters: ParameterSet, judgements: tuple[Judgement, ...]) -> Identification:
    """Return a given model and its errors as reports take an identified one: nothing was fitted."""
    return Identification(
        parameters=parameters,
        records=judgements,
        noise_rms=float(np.sqrt(np.mean([j.noise**2 for j in judgements]))),
    )
