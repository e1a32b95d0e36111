"""A run that every FMU carries with it, input and result, to be repeated in its host.

The files follow the layered standard fmi-ls-ref, which names them in a manifest:
`extra/org.fmi-standard.fmi-ls-ref/`.
"""

import math
from collections.abc import Mapping
from importlib.resources import files

import numpy as np
from lxml import etree

from it2hys.model import compiled
from it2hys.model.effect import Scalar
from it2hys.model.parameters import ParameterSet
from it2hys.model.stages import BEHIND_CORE

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
STANDARD = {
    "name": "org.fmi-standard.fmi-ls-ref",
    "version": "1.0.0-alpha.1",
    "description": "Layered Standard providing information on related files included in an FMU.",
}
TICKS = 400
# type, source relative to the manifest, role, description
RELATED = (
    ("text/csv", "input.csv", "testcase", "Input of the reference run, one row for each sample time"),
    ("text/csv", "result.csv", "result", "Outputs of the reference run at every communication point"),
    (
        "application/x-ssp-parameter-set",
        "../../resources/parameters.ssv",
        "parameter",
        "The parameter set that the FMU starts from",
    ),
    ("text/html", "../../documentation/index.html", "document", "Equations, timing and parameters"),
    ("text/html", "../../documentation/fmi-ls-ref.html", "document", "How to repeat the reference run"),
)


def reference_files(model: str, parameters: ParameterSet) -> dict[str, bytes]:
    """Return the files of the reference run by their path in the FMU.

    Parameters
    ----------
    model : {"plant", "inverse"}
        Which FMU.
    parameters : ParameterSet
        The set that the FMU starts from.
    """
    inputs, outputs = reference_run(model, parameters)
    sample_time = parameters["sampleTime"]
    return {
        f"{FOLDER}/fmi-ls-manifest.xml": format_manifest(),
        f"{FOLDER}/input.csv": _format_csv(sample_time, inputs),
        f"{FOLDER}/result.csv": _format_csv(sample_time, outputs),
        "documentation/fmi-ls-ref.html": (
            files("it2hys.fmu") / "templates" / "fmi-ls-ref.html"
        ).read_bytes(),
    }


def reference_run(model: str, parameters: ParameterSet) -> tuple[dict, dict]:
    """Return the inputs at every tick and the outputs at every communication point.

    The chain runs with all its effects, under a force and a temperature that change. The inverse's
    reference goes from where the displacement starts to near the far end of its range and back; the
    plant gets the voltage that would take its core there alone, which its amplifier need not let
    through. A row of the outputs is what is read at its time: the result of the tick before.
    """
    start, limits = parameters["initialDisplacement"], parameters.displacement_range
    force, temperature = _quantised(2.0 * _wave(3)), _quantised(293.15 + 2.0 * _wave(2))
    around = {"force": force, "temperature": temperature}
    if model == "inverse":
        reference = _quantised(_excursion(start, limits))
        voltage, saturated = compiled.chain_inverse_run(parameters, reference, force, temperature)
        return {"reference": reference, **around}, {
            "voltage": _read_later(compiled.chain_equilibrium(parameters), voltage),
            "saturated": _read_later(0, saturated.astype(int)),
        }
    begin = _core_start(parameters)
    way = _excursion(begin, limits)
    before = np.concatenate([[begin], way[:-1]])
    voltage = _quantised(compiled.solve(parameters.rules, before, way, limits))
    displacement, measured = compiled.chain_free_run(parameters, voltage, force, temperature)
    outside = compiled.chain_out_of_range(parameters, voltage, force, temperature)
    return {"voltage": voltage, **around}, {
        "displacement": _read_later(start, displacement),
        "measured": _read_later(start, measured),
        "outOfRange": _read_later(0, outside.astype(int)),
    }


def _read_later(before: float, ticks: np.ndarray) -> np.ndarray:
    """Return what a master reads at the ticks' times: before the first tick, then the tick before."""
    return np.concatenate([[before], ticks[:-1]])


def _wave(periods: int) -> np.ndarray:
    return np.sin(2 * math.pi * periods * np.arange(TICKS) / TICKS)


def _core_start(parameters: ParameterSet) -> float:
    """Return where the core begins, of which the stages behind it make the displacement."""
    displacement: Scalar = parameters["initialDisplacement"]
    for effect in reversed(BEHIND_CORE.values()):
        if effect.is_on(parameters):
            displacement, _ = effect.rest(parameters, displacement)
    return float(displacement)


def _excursion(start: float, limits: tuple[float, float]) -> np.ndarray:
    """Return displacements from a start to near the farther end of a range and back.

    Where the start is outside the range, they begin at that end.
    """
    low, high = limits
    start = min(max(start, low), high)
    share = 0.9 if start < (low + high) / 2 else 0.1
    far = low + share * (high - low)
    cycle = 2 * math.pi * np.arange(TICKS) / TICKS
    return start + (far - start) * 0.5 * (1 - np.cos(cycle))


def _quantised(values: np.ndarray) -> np.ndarray:
    """Round to multiples of a power of two.

    A master that interpolates linearly between rows then gets the rows' own values, to the last bit.
    """
    quantum = 2.0 ** (math.frexp(float(np.max(np.abs(values))))[1] - 32)
    return np.round(values / quantum) * quantum


def _format_csv(sample_time: float, columns: Mapping[str, np.ndarray]) -> bytes:
    """Return a table whose decimals read back to the same bits."""
    lines = [",".join(["time", *columns])]
    for tick, row in enumerate(zip(*(c.tolist() for c in columns.values()), strict=True)):
        lines.append(",".join(map(repr, [tick * sample_time, *row])))
    return ("\n".join(lines) + "\n").encode()


def format_manifest() -> bytes:
    """Return fmi-ls-manifest.xml."""
    root = etree.Element("fmiReferences", nsmap={"fmi-ls": NAMESPACE})
    for key, value in STANDARD.items():
        root.set(f"{{{NAMESPACE}}}fmi-ls-{key}", value)
    for kind, source, role, description in RELATED:
        etree.SubElement(root, "Related", type=kind, source=source, role=role, description=description)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)
