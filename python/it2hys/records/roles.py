"""One record, one role: what was fitted can neither decide nor be reported on as unseen."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from it2hys.errors import InputError
from it2hys.records.record import Record


def check_roles(train: Sequence[Record], validation: Sequence[Record], test: Sequence[Record]) -> None:
    """Refuse a record that is given in two roles, under whatever name.

    Raises
    ------
    InputError
        If records of two roles hold the same samples.
    """
    roles = {"training": train, "validation": validation, "test": test}
    for (first, ones), (second, others) in combinations(roles.items(), 2):
        for one in ones:
            for other in others:
                if _same(one, other):
                    raise InputError(
                        f"the {second} record '{other.name}' holds the same samples as the {first} "
                        f"record '{one.name}'; a record has one role"
                    )


def _same(one: Record, other: Record) -> bool:
    return np.array_equal(one.displacement, other.displacement) and np.array_equal(
        one.voltage, other.voltage
    )
