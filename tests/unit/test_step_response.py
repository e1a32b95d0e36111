"""What the response to a step is fitted with."""

import numpy as np
import pytest

from it2hys.diagnosis.evidence import statistics


def test_a_fit_that_goes_in_circles_is_ended_another_way(monkeypatch):
    rng = np.random.default_rng(1)
    columns = np.cumsum(np.exp(-np.arange(48)[:, None] / np.geomspace(0.1, 200.0, 10)), axis=0)
    target = columns @ rng.exponential(1.0, 10) + rng.standard_normal(48)
    _, squares = statistics._without_negative(columns, target)

    def circles(*_):
        raise RuntimeError("Maximum number of iterations reached.")

    monkeypatch.setattr(statistics, "nnls", circles)
    weights, again = statistics._without_negative(columns, target)
    assert np.all(weights >= 0.0)
    assert again == pytest.approx(squares, rel=1e-9)
    assert again == pytest.approx(np.sum((columns @ weights - target) ** 2), rel=1e-9)
