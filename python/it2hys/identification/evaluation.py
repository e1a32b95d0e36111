"""How a given model does on records: nothing is fitted but how each record begins."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from it2hys.identification.criterion import Model, Trace
from it2hys.identification.effect_coordinates import BY_RECORD
from it2hys.identification.judgement import judge
from it2hys.identification.lead_in import Misfit
from it2hys.identification.prediction import judge_new
from it2hys.identification.preparation import Prepared, check_sample_times, data_scaling, prepare
from it2hys.identification.result import Options, RecordResult
from it2hys.identification.starts import Starts
from it2hys.identification.traces import extent_of, to_trace
from it2hys.model.chain import active_effects
from it2hys.model.parameters import ParameterSet
from it2hys.model.variables import load_table
from it2hys.records import Record


def evaluate(
    parameters: ParameterSet,
    records: Sequence[Record],
    offsets: bool = False,
    options: Options | None = None,
) -> list[RecordResult]:
    """Run a model with all its effects on records, in free run and one step ahead.

    Parameters
    ----------
    parameters : ParameterSet
        The model.
    records : sequence of Record
        All at one sample time.
    offsets : bool
        Let every record differ from the model by a constant, which is removed.
    options : Options, optional

    Returns
    -------
    list of RecordResult
        With the role "test". What is one step ahead is NaN for a model with effects: a reading alone
        does not give the states that they have.

    Raises
    ------
    InputError
        If the sample times differ.
    """
    check_sample_times(records)
    prepared = [prepare(record, options or Options()) for record in records]
    if active_effects(parameters):
        return _with_effects(parameters, prepared, offsets)
    scaling = data_scaling(prepared)
    return [judge_new(p, "test", parameters, scaling, offsets, Misfit()) for p in prepared]


def _with_effects(
    parameters: ParameterSet, prepared: Sequence[Prepared], offsets: bool
) -> list[RecordResult]:
    traces = [to_trace(p, "test", offsets) for p in prepared]
    effects, known = active_effects(parameters), load_table().parameters()
    own = {
        name: np.full(len(traces), parameters[name])
        for name in BY_RECORD
        if known[name].effect in (None, *effects)
    }
    extent = extent_of([p.record for p in prepared])
    starts = Starts(traces, data_scaling(prepared), extent)
    given = Model(dict(parameters), tuple(effects), np.zeros(len(traces)), own)
    begun = starts.fit_own(given, traces)
    return [
        _result(p, t, parameters, begun.start(i), float(begun.offsets[i]))
        for i, (p, t) in enumerate(zip(prepared, traces, strict=True))
    ]


def _result(
    prepared: Prepared, trace: Trace, parameters: ParameterSet, start: dict, offset: float
) -> RecordResult:
    judged = judge(trace, parameters, start, offset)
    return RecordResult(
        name=judged.name,
        role=judged.role,
        e_mr=judged.e_mr,
        e_rms=judged.e_rms,
        e_mr_one_step=np.nan,
        e_rms_one_step=np.nan,
        offset=offset,
        initial_displacement=judged.start["initialDisplacement"],
        skip=judged.lead,
        noise_rms=prepared.noise.rms,
        noise_method=prepared.noise.method,
        y_free=judged.y,
        y_one_step=np.full(len(judged.y), np.nan),
        used=judged.used,
        out_of_range=judged.out_of_range,
        start=judged.start,
    )
