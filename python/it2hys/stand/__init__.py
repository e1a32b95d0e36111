"""The paper's test stand, simulated, to identify and control something that is not the model.

It shares no code and no parameterisation with the model chain and runs on a finer time grid.
`Stand` is put together from its parts, each a frozen dataclass in SI units:

>>> from dataclasses import replace
>>> from it2hys.stand import Hum, Mechanics, Stand
>>> stand = replace(Stand(), creep=None, mechanics=Mechanics(damping=0.03), hum=Hum())
>>> reading = stand.run([0.0, 10.0, 20.0], seed=1)
>>> running = stand.start(seed=1)
>>> bool(abs(running.step(0.0) - reading.measured[0]) < 1e-12)
True
"""

from it2hys.stand.amplifier import Amplifier
from it2hys.stand.converters import Converter
from it2hys.stand.creep import Creep
from it2hys.stand.gauge import Gauge, Hum
from it2hys.stand.hysteresis import Hysteresis
from it2hys.stand.mechanics import Mechanics, ThermalExpansion
from it2hys.stand.stand import LINEAR_SLOPE, NOMINAL_GAIN, Reading, RunningStand, Stand

#: What a scenario may leave out, by the names of the fields of `Stand`.
PARTS = ("dac", "amplifier", "hysteresis", "creep", "mechanics", "thermal", "gauge", "adc")

__all__ = [
    "LINEAR_SLOPE",
    "NOMINAL_GAIN",
    "PARTS",
    "Amplifier",
    "Converter",
    "Creep",
    "Gauge",
    "Hum",
    "Hysteresis",
    "Mechanics",
    "Reading",
    "RunningStand",
    "Stand",
    "ThermalExpansion",
]
