"""What the names in a scenario stand for: variables of FMUs, arguments of signals."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence

import numpy as np
from fmpy.model_description import ModelDescription, ScalarVariable

from it2hys.cosimulation.faces import FACES, untransferable
from it2hys.errors import InputError
from it2hys.stand import excitations
from it2hys.support.keys import known_names
from it2hys.sweeps.plan import Setup, argument
from it2hys.sweeps.schema import CSV, CSV_NUMBERS, Source, SweepScenario

#: Targets that are no variable and no argument.
OWN = ("step", "duration")


class Lookup:
    """Finds what targets and outputs name, and says which name is wrong."""

    def __init__(
        self,
        scenario: SweepScenario,
        descriptions: Mapping[str, ModelDescription],
        signals: Mapping[str, Source],
    ) -> None:
        self.scenario, self.signals = scenario, signals
        self.variables = {
            fmu: {v.name: v for v in description.modelVariables}
            for fmu, description in descriptions.items()
        }
        self.faces = {fmu: FACES[d.fmiVersion] for fmu, d in descriptions.items()}
        self.starts = {fmu.name: fmu.start for fmu in scenario.fmus}

    def variable(self, place: str, name: str) -> ScalarVariable:
        """Return a variable named ``fmu.variable``."""
        fmu, _, variable = name.partition(".")
        if fmu not in self.variables:
            known = known_names(fmu, [*self.variables, *self.signals])
            raise InputError(f"{place}: there is no FMU or signal {fmu!r}; {known}")
        if variable not in self.variables[fmu]:
            known = known_names(variable, list(self.variables[fmu]))
            raise InputError(f"{place}: the FMU {fmu!r} has no variable {variable!r}; {known}")
        return self.variables[fmu][variable]

    def check_output(self, place: str, name: str, setups: Sequence[Setup]) -> None:
        """Check a signal's name, or an output that every variant has."""
        if "." not in name:
            if name not in self.signals:
                known = known_names(name, list(self.signals))
                raise InputError(f"{place}: there is no signal {name!r}; {known}; outputs are FMU.name")
            return
        variable = self.variable(place, name)
        if fault := untransferable(self.faces[name.partition(".")[0]], variable):
            raise InputError(f"{place}: {name} {fault}")
        for setup in setups:
            if name.partition(".")[0] not in setup.fmus:
                raise InputError(
                    f"{place}: {name} does not exist in the variant {setup.name!r}, "
                    "whose connections leave that FMU out"
                )

    def unit(self, name: str) -> str:
        """Return the SI unit of an output; of a signal, that of the input it goes to."""
        if "." in name:
            variable = self.variable("unit", name)
            return (
                variable.unit or (variable.declaredType.unit if variable.declaredType else None) or "1"
            )
        targets = [c.target for v in self.scenario.variants for c in v.connections if c.source == name]
        return self.unit(targets[0]) if targets else "1"

    def target_unit(self, target: str) -> str:
        """Return the unit of what is varied."""
        name, _, key = target.partition(".")
        if name not in self.signals:
            return "s" if target in OWN else self.unit(target)
        if "frequency" in key:
            return "Hz"
        if key in ("low", "high", "offset"):
            return self.unit(name)
        return "s" if key in ("hold", "time_constant", "duration") else "1"

    def check_target(self, place: str, target: str, values: Sequence[float]) -> float:
        """Check that a target exists and takes some values; return what it is without them."""
        name, _, key = target.partition(".")
        if target in OWN:
            self._check_range(place, target, values, (np.nextafter(0.0, 1.0), None))
            span = self.scenario.duration.seconds
            return self.scenario.step if target == "step" else span
        if name in self.signals:
            return argument_of_kind(place, self.signals[name], key)
        variable = self.variable(place, target)
        if variable.causality not in ("parameter", "input") or variable.variability == "constant":
            raise InputError(f"{place}: {target} is {variable.causality}; it cannot be set")
        kind = self.faces[name].types.get(variable.type, ("", str))[1]
        if kind is str:
            raise InputError(f"{place}: {target} is a {variable.type}; only numbers can be set")
        self._check_range(place, target, values, _bounds(variable))
        if kind is int and (parts := [v for v in values if v != round(v)]):
            raise InputError(f"{place}: {target} is {parts[0]:g}; it must be a whole number")
        start = self.starts[name].get(key, variable.start)
        return float(start == "true") if start in ("true", "false") else float(start or 0.0)

    @staticmethod
    def _check_range(place: str, target: str, values: Sequence[float], bounds: tuple) -> None:
        low, high = bounds
        for value in values:
            if isinstance(value, bool):
                continue
            if not isinstance(value, int | float) or not np.isfinite(value):
                raise InputError(f"{place}: {target} is {value!r}; it must be a finite number")
            if (low is not None and value < low) or (high is not None and value > high):
                text = (
                    f"{'-∞' if low is None else f'{low:g}'} to {'∞' if high is None else f'{high:g}'}"
                )
                raise InputError(f"{place}: {target} is {value:g}; it must be {text}")


def argument_of_kind(place: str, source: Source, key: str) -> float:
    """Return the value of a signal's argument that is a number, NaN where it is not given."""
    if source.signal == CSV:
        known = list(CSV_NUMBERS)
    else:
        known = list(inspect.signature(excitations.SIGNALS[source.signal]).parameters)[1:]
    if key not in known:
        raise InputError(
            f"{place}: the signal {source.name!r} ({source.signal}) has no argument {key!r}; "
            f"{known_names(key, known)}"
        )
    try:
        value = argument(source, key)
    except InputError:
        return float("nan")
    return float(value) if isinstance(value, int | float) else float("nan")


def _bounds(variable: ScalarVariable) -> tuple[float | None, float | None]:
    def number(name: str) -> float | None:
        for holder in (variable, variable.declaredType):
            text = getattr(holder, name, None)
            if text is not None:
                return float(text)
        return None

    return number("min"), number("max")
