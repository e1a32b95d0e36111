"""Measured records: CSV files with units in the header, read into SI and checked.

A file passes three gates, and each failure is one message that names the file, the line, the
column and the mend:

1. the text (`text`, `columns`, `units`, together in `table`): a header, one delimiter, a finite
   number in every field that is needed;
2. the time base (`time_base`, `resampling`): rising and uniform, or made so;
3. plausibility (`plausibility`, `lead`, `response`): the signals move, within what a piezo stage can
   do, and the displacement answers its voltage: it does not run ahead of it, and rises with it.

What is odd but usable (a spike, a clipped sensor, an assumed unit) is told in `Record.notes`, and
the samples concerned are marked in `Record.outliers`.
"""

from it2hys.records.columns import ColumnChoice, parse_column_option
from it2hys.records.reading import read_record
from it2hys.records.record import Record
from it2hys.records.response import check_response
from it2hys.records.roles import check_roles
from it2hys.records.text import record_name
from it2hys.records.units import UNITS
from it2hys.records.writing import write_record

__all__ = [
    "UNITS",
    "ColumnChoice",
    "Record",
    "check_response",
    "check_roles",
    "parse_column_option",
    "read_record",
    "record_name",
    "write_record",
]
