"""The test stand of the paper, simulated: the parts in a row, on a finer grid than the sampling.

    voltage -> dead time -> D/A -> amplifier -> hysteresis -> creep -> mechanics (force, heat)
            -> strain gauge conditioner (+ hum, noise) -> A/D -> reading

Sampling convention: tick k lies at ``t_k = k Ts``. The computer sets ``voltage[k]`` at t_k and
the D/A holds it until t_{k+1}. The reading with index k is taken just before the next update,
at the end of the interval in which ``voltage[k]`` acted, so that it responds to ``voltage[k]``
as in ``y_k = F(y_{k-1}, x_k)``. Everything starts at rest at 0 V, where displacement counts from.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from it2hys.errors import InputError
from it2hys.stand.amplifier import Amplifier
from it2hys.stand.checks import finite_signal, require, require_finite
from it2hys.stand.converters import Converter, Delay
from it2hys.stand.creep import Creep
from it2hys.stand.gauge import Gauge, Hum
from it2hys.stand.hysteresis import Hysteresis
from it2hys.stand.mechanics import Mechanics, ThermalExpansion

# The computer divides the stack voltage that it wants by this, and outputs the result.
NOMINAL_GAIN = 15.0
# Slope of a stack without hysteresis, m/V: the paper's travel on its voltage range.
LINEAR_SLOPE = 15.5e-6 / 105.0
# Ticks simulated at once, which bounds the memory.
_CHUNK = 50_000


@dataclass(frozen=True)
class Reading:
    """What one run of the stand gives; all arrays have shape (n,) and the ticks' index.

    Parameters
    ----------
    time : numpy.ndarray
        Tick times t_k, s.
    command : numpy.ndarray
        Stack voltage that was asked for, set at t_k, V.
    amplifier : numpy.ndarray
        Stack voltage that was reached at t_{k+1}, V.
    displacement : numpy.ndarray
        True displacement at t_{k+1}, m.
    measured : numpy.ndarray
        Reading of the A/D at t_{k+1}, m.
    """

    time: np.ndarray
    command: np.ndarray
    amplifier: np.ndarray
    displacement: np.ndarray
    measured: np.ndarray


@dataclass(frozen=True)
class Stand:
    """The parts of the test stand; a part that is None is replaced by an ideal one.

    Parameters
    ----------
    dead_time : float
        Delay between the computer and the D/A, s; rounded to the fine grid.
    dac : Converter or None
        None: no quantisation, no limits.
    amplifier : Amplifier or None
        None: the D/A voltage times the nominal gain, at once and without limits.
    hysteresis : Hysteresis or None
        None: a straight line of the paper's travel over its voltage range.
    creep : Creep or None
        None: no creep.
    mechanics : Mechanics or None
        None: massless and rigid; a force has no effect.
    thermal : ThermalExpansion or None
        None: a temperature has no effect.
    gauge : Gauge or None
        None: straight and without lag, at the nominal sensitivity.
    hum : Hum or None
        None (the default): no hum.
    noise : float
        Standard deviation of the white noise in the reading, m; 0 for none.
    adc : Converter or None
        None: no quantisation, no limits.
    substeps : int
        Fine steps in a sample time.

    Raises
    ------
    InputError
        If a value is out of its domain.
    """

    dead_time: float = 0.0
    dac: Converter | None = field(default_factory=Converter)
    amplifier: Amplifier | None = field(default_factory=Amplifier)
    hysteresis: Hysteresis | None = field(default_factory=Hysteresis)
    creep: Creep | None = field(default_factory=Creep)
    mechanics: Mechanics | None = field(default_factory=Mechanics)
    thermal: ThermalExpansion | None = field(default_factory=ThermalExpansion)
    gauge: Gauge | None = field(default_factory=Gauge)
    hum: Hum | None = None
    noise: float = 6e-9
    adc: Converter | None = field(default_factory=Converter)
    substeps: int = 10

    def __post_init__(self):
        """Refuse values out of their domain."""
        require_finite(self, "dead_time", "noise", minimum=0.0)
        integer = isinstance(self.substeps, int | np.integer)
        require(self, integer and self.substeps >= 1, "substeps must be a whole number from 1 up")

    def start(self, seed=0, sample_time=1e-4):
        """Switch the stand on, at rest at 0 V, for use sample by sample.

        Parameters
        ----------
        seed : int
            Seed of the noise.
        sample_time : float
            Sample time Ts, s.

        Returns
        -------
        RunningStand

        Raises
        ------
        InputError
            If the sample time is not positive and finite.
        """
        return RunningStand(self, seed, sample_time)

    def run(self, voltage, sample_time=1e-4, seed=0, force=None, temperature=None):
        """Drive the stand with a whole signal.

        Gives the readings that `start` and `RunningStand.step` give with the same seed.

        Parameters
        ----------
        voltage : array_like, shape (n,)
            Stack voltage asked for at each tick, V.
        sample_time : float
            Sample time Ts, s.
        seed : int
            Seed of the noise.
        force : array_like, shape (n,), optional
            Force on the tip, compressive positive, held from tick to tick, N.
        temperature : array_like, shape (n,), optional
            Temperature of the stack, held from tick to tick, K; the reference if not given.

        Returns
        -------
        Reading

        Raises
        ------
        InputError
            If an input is empty, not finite or of another length than the voltage.
        """
        voltage = finite_signal(voltage, "voltage")
        if force is not None:
            force = finite_signal(force, "force", voltage.size)
        if temperature is not None:
            temperature = finite_signal(temperature, "temperature", voltage.size)
        running = self.start(seed, sample_time)
        amplifier, displacement, measured = running.advance(voltage, force, temperature)
        return Reading(
            time=np.arange(voltage.size) * sample_time,
            command=voltage.copy(),
            amplifier=amplifier,
            displacement=displacement,
            measured=measured,
        )

    def record(self, voltage, name, sample_time=1e-4, seed=0, force=None, temperature=None):
        """Drive the stand and give the measurement as a record of the identification.

        Parameters
        ----------
        voltage, sample_time, seed, force, temperature
            As in `run`.
        name : str
            Name of the record.

        Returns
        -------
        it2hys.records.Record
            The voltage asked for, the reading and the auxiliary inputs that were given.

        Raises
        ------
        InputError
            As `run`.
        """
        from it2hys.records import Record  # keeps the rig usable without the identification

        reading = self.run(voltage, sample_time, seed, force, temperature)
        return Record(
            name=name,
            time=reading.time,
            voltage=reading.command,
            displacement=reading.measured,
            sample_time=sample_time,
            force=None if force is None else np.array(force, dtype=float),
            temperature=None if temperature is None else np.array(temperature, dtype=float),
        )


class RunningStand:
    """A stand that is switched on, with the states of all its parts; see `Stand.start`.

    Attributes
    ----------
    amplifier_voltage : float
        Stack voltage at the last reading, V.
    displacement : float
        True displacement at the last reading, m.

    Parameters
    ----------
    stand : Stand
        The parts.
    seed : int
        Seed of the noise.
    sample_time : float
        Sample time, s.
    """

    def __init__(self, stand, seed, sample_time):
        if not 0.0 < sample_time < math.inf:
            raise InputError(f"rig: the sample time must be positive, not {sample_time!r}")
        step = sample_time / stand.substeps
        self._stand = stand
        self._sample_time = sample_time
        self._generator = np.random.default_rng(seed)
        self._tick = 0
        self._delay = Delay(round(stand.dead_time / step))
        self._amplifier = stand.amplifier and stand.amplifier.start(step)
        self._hysteresis = stand.hysteresis and stand.hysteresis.start()
        self._creep = stand.creep and stand.creep.start(step)
        self._mechanics = stand.mechanics and stand.mechanics.start(step)
        self._gauge = stand.gauge or Gauge(nonlinearity=0.0, bandwidth=math.inf)
        self._gauge_filter = self._gauge.start(step)
        self.amplifier_voltage = 0.0
        self.displacement = 0.0

    def step(self, voltage, force=None, temperature=None):
        """Hold a voltage for one sample time and read the gauge at its end.

        Parameters
        ----------
        voltage : float
            Stack voltage asked for, V.
        force : float, optional
            Force on the tip, compressive positive, N.
        temperature : float, optional
            Temperature of the stack, K; the reference if not given.

        Returns
        -------
        float
            The reading, m.

        Raises
        ------
        InputError
            If an input is not finite.
        """
        inputs = [
            value if value is None else finite_signal([value], name)
            for name, value in (
                ("voltage", voltage),
                ("force", force),
                ("temperature", temperature),
            )
        ]
        return float(self.advance(*inputs)[2][0])

    def advance(self, voltage, force=None, temperature=None):
        """Go on by any number of ticks.

        Parameters
        ----------
        voltage : numpy.ndarray, shape (n,)
            Stack voltage asked for, V, finite.
        force, temperature : numpy.ndarray, shape (n,), optional
            As in `Stand.run`.

        Returns
        -------
        tuple of numpy.ndarray, each of shape (n,)
            Stack voltage (V), true displacement (m) and reading (m) at the end of each tick.
        """
        pieces = []
        for begin in range(0, voltage.size, _CHUNK):
            part = slice(begin, begin + _CHUNK)
            fine_voltage, fine_displacement = self._actuate(
                voltage[part],
                None if force is None else force[part],
                None if temperature is None else temperature[part],
            )
            last = slice(self._stand.substeps - 1, None, self._stand.substeps)
            measured = self._measure(fine_displacement, last)
            pieces.append((fine_voltage[last], fine_displacement[last], measured))
        columns = tuple(np.concatenate(column) for column in zip(*pieces, strict=True))
        self.amplifier_voltage, self.displacement = columns[0][-1], columns[1][-1]
        return columns

    def _actuate(self, voltage, force, temperature):
        """Give stack voltage and true displacement on the fine grid."""
        stand = self._stand
        output = voltage / NOMINAL_GAIN
        if stand.dac is not None:
            output = stand.dac.convert(output)
        output = self._delay.advance(self._hold(output))
        if self._amplifier is not None:
            stack = self._amplifier.advance(output)
        else:
            stack = NOMINAL_GAIN * output
        if self._hysteresis is not None:
            displacement = self._hysteresis.advance(stack)
        else:
            displacement = LINEAR_SLOPE * stack
        if self._creep is not None:
            displacement = self._creep.advance(displacement)
        if self._mechanics is not None:
            if force is not None:
                displacement = displacement - self._hold(force) / stand.mechanics.stiffness
            displacement = self._mechanics.advance(displacement)
        if stand.thermal is not None and temperature is not None:
            displacement = displacement + self._hold(stand.thermal.displacement(temperature))
        return stack, displacement

    def _measure(self, displacement, last):
        """Give the readings; `last` picks the fine samples at which they are taken."""
        stand, gauge = self._stand, self._gauge
        if self._gauge_filter is not None:
            displacement = self._gauge_filter.advance(displacement)
        volts = gauge.volts(displacement[last])
        ticks = np.arange(self._tick + 1, self._tick + 1 + volts.size)
        self._tick += volts.size
        disturbance = stand.noise * self._generator.standard_normal(volts.size)
        if stand.hum is not None:
            disturbance += stand.hum.reading(ticks * self._sample_time)
        volts = volts + gauge.sensitivity * disturbance
        if stand.adc is not None:
            volts = stand.adc.convert(volts)
        return gauge.reading(volts)

    def _hold(self, values):
        return np.repeat(values, self._stand.substeps)
