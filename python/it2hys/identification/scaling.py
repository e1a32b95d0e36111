"""Scaling of records to numbers of order one, and the exact map of rules that goes with it.

Under y' = a y + b, x' = c x + d, (10) keeps its form if every rule is mapped as

    s1' = |a| s1,  s2' = |a| s2,  c' = a c + b,
    q1' = q1,  q2' = (a / c) q2,  q3' = a q3 + (1 - q1) b - q2' d,

because memberships depend on (y - c_l) / s_l alone and the weights of (10) sum to one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class Scaling:
    """The map y' = (y - y_centre) / y_unit, x' = (x - x_centre) / x_unit.

    Parameters
    ----------
    y_centre, y_unit : float
        Displacement that becomes 0 and the one that becomes 1 above it, m.
    x_centre, x_unit : float
        The same for the voltage, V.
    """

    y_centre: float
    y_unit: float
    x_centre: float
    x_unit: float

    @classmethod
    def of_data(cls, displacement: np.ndarray, voltage: np.ndarray) -> Scaling:
        """Return the scaling that takes the range of both signals to [-1, 1]."""
        (y_low, y_high), (x_low, x_high) = (
            (np.min(values), np.max(values)) for values in (displacement, voltage)
        )
        return cls(
            (y_low + y_high) / 2, (y_high - y_low) / 2, (x_low + x_high) / 2, (x_high - x_low) / 2
        )

    def y(self, displacement: np.ndarray | float) -> np.ndarray | float:
        """Return displacements in m as scaled numbers."""
        return (displacement - self.y_centre) / self.y_unit

    def x(self, voltage: np.ndarray | float) -> np.ndarray | float:
        """Return voltages in V as scaled numbers."""
        return (voltage - self.x_centre) / self.x_unit

    def displacement(self, y: np.ndarray | float) -> np.ndarray | float:
        """Return scaled displacements in m."""
        return self.y_centre + self.y_unit * y

    def voltage(self, x: np.ndarray | float) -> np.ndarray | float:
        """Return scaled voltages in V."""
        return self.x_centre + self.x_unit * x

    def rules(self, physical: np.ndarray) -> np.ndarray:
        """Return rules in SI units, shape (L, 6), as rules of the scaled signals."""
        return _map_rules(
            physical,
            1 / self.y_unit,
            -self.y_centre / self.y_unit,
            1 / self.x_unit,
            -self.x_centre / self.x_unit,
        )

    def physical_rules(self, scaled: np.ndarray) -> np.ndarray:
        """Return rules of the scaled signals, shape (L, 6), in SI units."""
        physical = scaled @ self._by_rule.T
        physical[:, 2] += self.y_centre
        physical[:, 5] += self.y_centre
        return physical

    def rule_jacobian(self, scaled: np.ndarray) -> np.ndarray:
        """Return d(rules in SI units) / d(scaled rules), shape (6 L, 6 L), row by row of the rules.

        The map is affine in a rule, so that the Jacobian is constant.
        """
        count = len(scaled)
        result = np.zeros((count, 6, count, 6))
        for i in range(count):
            result[i, :, i] = self._by_rule
        return result.reshape(6 * count, 6 * count)

    @cached_property
    def _by_rule(self) -> np.ndarray:
        """The Jacobian of one rule, shape (6, 6)."""
        gain = self.y_unit / self.x_unit
        block = np.diag([self.y_unit, self.y_unit, self.y_unit, 1.0, gain, self.y_unit])
        block[5, 3] = -self.y_centre
        block[5, 4] = -gain * self.x_centre
        return block


def moved(rules: np.ndarray, distance: float) -> np.ndarray:
    """Return the rules, shape (L, 6), of a core whose displacement is larger by a distance."""
    return _map_rules(rules, 1.0, distance, 1.0, 0.0)


def relaxed(rules: np.ndarray, share: float) -> np.ndarray:
    """Return the rules, shape (L, 6), of a core that goes a share of the way.

    y + share (F(y, x) - y) has the form of (10), because the weights sum to one: it rests where F does.
    """
    result = np.array(rules, dtype=float)
    result[:, 3] = 1.0 + share * (result[:, 3] - 1.0)
    result[:, 4:] *= share
    return result


def _map_rules(rules: np.ndarray, a: float, b: float, c: float, d: float) -> np.ndarray:
    """Return the rules of y' = a y + b, x' = c x + d."""
    lower, upper, centre, q1, q2, q3 = np.asarray(rules, dtype=float).T
    gain = a / c * q2
    return np.column_stack(
        [abs(a) * lower, abs(a) * upper, a * centre + b, q1, gain, a * q3 + (1 - q1) * b - gain * d]
    )
