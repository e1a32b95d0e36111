"""How a given model does on records: nothing is fitted but each record's initial state."""

from __future__ import annotations

from collections.abc import Sequence

from it2hys.identification.prediction import judge_new
from it2hys.identification.preparation import check_sample_times, data_scaling, prepare
from it2hys.identification.result import Options, RecordResult
from it2hys.parameters import ParameterSet
from it2hys.records import Record


def evaluate(
    parameters: ParameterSet,
    records: Sequence[Record],
    offsets: bool = False,
    options: Options | None = None,
) -> list[RecordResult]:
    """Run a model on records, in free run and one step ahead.

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
        With the role "test".

    Raises
    ------
    InputError
        If the sample times differ or the free run diverges.
    """
    check_sample_times(records)
    prepared = [prepare(record, options or Options()) for record in records]
    scaling = data_scaling(prepared)
    rules = scaling.rules(parameters.rules)
    return [judge_new(p, "test", rules, scaling, offsets) for p in prepared]
