"""Physics beside the catalogue's, for which a user writes effects of his own; see `simulator`.

Nothing of the files in `examples/own_effects` is used: each has its own equations here, on the fine
grid where they know time.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from diagnosis.simulator import Surroundings


@dataclass(frozen=True)
class Mount:
    """A base of its own mass, on a spring and a damper, that a moving stage pushes back.

    Parameters
    ----------
    ratio : float
        Moving mass over that of the base with the stage on it.
    frequency, damping : float
        Natural frequency of the base, Hz, and Lehr's damping.
    """

    ratio: float
    frequency: float
    damping: float

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        w, d = 2.0 * np.pi * self.frequency, 2.0 * self.damping
        # s^2 over the denominator, as 1 less what is strictly proper
        slow = around.grid.filter([d / w, 1.0], [1.0 / w**2, d / w, 1.0], x)
        return x - self.ratio * (x - slow)


@dataclass(frozen=True)
class Guide:
    """Friction between stage and frame: many elements that stick and slip, in balance with the stack.

    Parameters
    ----------
    force : float
        Greatest force of all elements over the stack's stiffness, um.
    slip : float
        Mean distance after which an element slips, um; they are spread exponentially.
    elements : int
    """

    force: float
    slip: float
    elements: int = 24

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        slips = -self.slip * np.log1p(-(np.arange(self.elements) + 0.5) / self.elements)
        most = self.force / self.elements
        stiffness = most / slips
        result = np.empty_like(x.T)
        y, held = x[:, 0].copy(), np.zeros((len(x), self.elements))
        for k, pushed in enumerate(np.ascontiguousarray(x.T)):
            new = y.copy()
            for _ in range(50):  # the balance is piecewise linear and monotone: Newton ends
                trial = held + stiffness * (new - y)[:, None]
                stuck = np.abs(trial) < most
                excess = new - pushed + np.clip(trial, -most, most).sum(axis=1)
                step = excess / (1.0 + (stiffness * stuck).sum(axis=1))
                new = new - step
                if np.max(np.abs(step)) < 1e-12:
                    break
            held = np.clip(held + stiffness * (new - y)[:, None], -most, most)
            result[k] = y = new
        return result.T


@dataclass(frozen=True)
class SelfHeating:
    """A stack that loses a part of the energy it takes in and gives back, and expands with its heat.

    The power at its terminals is that of voltage and current; its charge is proportional to how long
    it is (which is why drives by charge have next to no hysteresis).

    Parameters
    ----------
    expansion : float
        At the temperature of a steady power of 1 V um/s, s/V: losses, resistance and coefficient in
        one.
    time : float
        Heat capacity times resistance, s.
    voltage : ndarray, shape (records, samples)
        What drives the stack, V.
    """

    expansion: float
    time: float
    voltage: np.ndarray = field(repr=False)

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        grid = around.grid
        voltage, current = grid.refine(self.voltage), np.diff(x, axis=1, prepend=x[:, :1]) / grid.step
        power = np.abs(voltage * current)
        share = -np.expm1(-grid.step / self.time)
        heat, temperature = np.zeros(len(x)), np.empty_like(power.T)
        for k, given in enumerate(np.ascontiguousarray(power.T)):
            heat = heat + share * (given - heat)
            temperature[k] = heat
        return x + self.expansion * temperature.T


@dataclass(frozen=True)
class Drag:
    """A stage in a thick fluid, whose drag grows with the speed and its square; its mass is nothing.

    Parameters
    ----------
    linear : float
        Drag over the stack's stiffness, s.
    square : float
        That of the square, s^2/um.
    """

    linear: float
    square: float

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        y, result = x[:, 0].copy(), np.empty_like(x.T)
        for k, pushed in enumerate(np.ascontiguousarray(x.T)):
            behind = pushed - y
            root = np.sqrt(self.linear**2 + 4.0 * self.square * np.abs(behind))
            # of linear v + square v |v| = behind, without the difference of two like numbers
            speed = 2.0 * behind / (self.linear + root)
            y = y + np.clip(around.grid.step * speed, -np.abs(behind), np.abs(behind))
            result[k] = y
        return result.T
