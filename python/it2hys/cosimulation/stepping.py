"""The fast path: connected FMUs stepped over whole signals by compiled code.

FMPy unpacks, describes and instantiates FMUs and stays at hand for everything that happens once in a
run; what happens at every step happens in `fmu_src/python/stepper.c`, which calls the FMI functions
by their addresses. It makes the calls that a loop over FMPy's `setReal`, `doStep` and `getReal` makes,
so the numbers are the same to the last bit.
"""

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from it2hys.cosimulation.faces import untransferable
from it2hys.cosimulation.slave import FATAL, Slave
from it2hys.errors import InputError
from it2hys.model.compiled import address, library_function

#: Memory of the numbers that FMI functions take, by `enum held` of stepper.c.
HELD = (np.float64, np.int32, np.int32, np.bool_)
#: Messages of failed calls, by `enum kind` of stepper.c.
FAILED = (
    "its inputs could not be set", "{}DoStep failed", "its outputs could not be read", "{}Reset failed",
    "{}SetupExperiment failed", "its parameters could not be set",
    "{}EnterInitializationMode failed", "{}ExitInitializationMode failed",
)  # fmt: skip
#: The last kind of a call that is of a step.
_LAST_OF_A_STEP = 2
STATUS = {
    2: "Discard", 3: "Error", FATAL: "Fatal", 5: "Pending (steps in the background)",
    6: "DoStep asks to end the simulation",
}  # fmt: skip
_ADDRESS = ctypes.c_void_p


@dataclass(frozen=True)
class Connection:
    """What an input gets: ``factor * source + offset``.

    `source` is a signal's name or ``slave.output``, `target` is ``slave.input``.
    """

    source: str
    target: str
    factor: float = 1.0
    offset: float = 0.0

    @property
    def as_it_is(self) -> bool:
        """Whether the input gets the source itself."""
        return self.factor == 1.0 and self.offset == 0.0


class _Value(ctypes.Structure):
    """`struct stepper_value` of stepper.c."""

    _fields_ = (
        ("factor", ctypes.c_double), ("offset", ctypes.c_double), ("values", _ADDRESS),
        ("course", ctypes.c_int32), ("this_step", ctypes.c_int32),
    )  # fmt: skip


class _Transfer(ctypes.Structure):
    """`struct stepper_transfer` of stepper.c."""

    _fields_ = (
        *((name, _ADDRESS) for name in ("function", "references", "values", "room")),
        ("count", ctypes.c_int64),
    )


class _Turn(ctypes.Structure):
    """`struct stepper_turn` of stepper.c."""

    _fields_ = (
        ("instance", _ADDRESS), ("step", _ADDRESS),
        ("set", _Transfer * len(HELD)), ("get", _Transfer * len(HELD)), ("version", ctypes.c_int32),
        *((name, _ADDRESS) for name in ("reset", "setup", "enter", "leave")),
        ("start", _Transfer * len(HELD)),
    )  # fmt: skip


class _Courses(ctypes.Structure):
    """`struct stepper_courses` of stepper.c."""

    _fields_ = (
        ("signals", ctypes.POINTER(_ADDRESS)), ("outputs", _ADDRESS), ("last", _ADDRESS),
        ("length", ctypes.c_int64), ("signal_count", ctypes.c_int32), ("output_count", ctypes.c_int32),
    )  # fmt: skip


class _Fault(ctypes.Structure):
    """`struct stepper_fault` of stepper.c."""

    _fields_ = (("slave", ctypes.c_int32), ("kind", ctypes.c_int32), ("status", ctypes.c_int32))


#: Result of the functions of stepper.c, and what they take behind turns and before a fault.
_FUNCTIONS = {
    "reset": (ctypes.c_bool,),
    "start": (ctypes.c_bool, ctypes.POINTER(_Courses)),
    "run": (
        ctypes.c_int64, ctypes.POINTER(_Courses), ctypes.c_int64, ctypes.c_int64, ctypes.c_double
    ),
}  # fmt: skip


@cache
def _function(name: str) -> ctypes._CFuncPtr:
    function = library_function(f"it2core_stepper_{name}")
    function.restype, *further = _FUNCTIONS[name]
    function.argtypes = [_ADDRESS, ctypes.c_int32, *further, ctypes.POINTER(_Fault)]
    return function


class System:
    """Connected FMUs that run one after the other in every communication step.

    A slave gets this step's outputs of the slaves before it and the last step's of those behind it:
    put the inverse before the plant, and a controller that reads the plant before the plant.

    Parameters
    ----------
    slaves : mapping of str to Slave
        In the order in which they step. A name has no dot.
    connections : sequence of Connection
        An input that none names keeps its start value.
    recorded : sequence of str
        Variables to be recorded, as ``slave.variable``.

    Raises
    ------
    InputError
        If a name is unknown, an input is connected twice, or a variable can be neither set nor
        recorded as a number, such as a String.
    """

    def __init__(
        self, slaves: Mapping[str, Slave], connections: Sequence[Connection], recorded: Sequence[str]
    ) -> None:
        self.slaves, self.recorded = dict(slaves), list(recorded)
        self._connections = {c.target: c for c in connections}
        if len(self._connections) < len(connections):
            targets = [c.target for c in connections]
            twice = next(t for t in targets if targets.count(t) > 1)
            raise InputError(f"the input {twice} is connected twice")
        sources = [c.source for c in connections]
        self.signals = list(dict.fromkeys(s for s in sources if "." not in s))
        self._slots = {name: i for i, name in enumerate(self.signals)}
        wanted = dict.fromkeys([*(s for s in sources if "." in s), *self.recorded])
        self._outputs = {name: self._by_base(name, wanted) for name in self.slaves}
        for name in wanted:
            self._find(name)
        for slave, groups in self._outputs.items():
            for group in groups.values():
                self._slots.update({f"{slave}.{v}": len(self._slots) + i for i, v in enumerate(group)})
        self._inputs = {name: self._by_base(name, self._connections) for name in self.slaves}
        for target in self._connections:
            slave, variable = self._find(target)
            if self.slaves[slave].variable(variable).causality != "input":
                raise InputError(f"{target} is no input of {self.slaves[slave].path}")
        self._last = np.zeros(len(self._slots))  # values before a step
        begin, first = self._last.ctypes.data, len(self.signals)
        ends = range(begin, begin + 8 * first, 8)
        last, further = begin + 8 * first, (first, len(self._last) - first)
        self._last_courses = _Courses((_ADDRESS * first)(*ends), last, last, 1, *further)
        self._places = (_ADDRESS * first)()  # of signals
        self._courses = _Courses(self._places, None, last, 0, *further)
        self._step = 0
        self._filled: tuple = ()  # instances and names of parameters that turns are filled in with
        self._kept: list = []  # arrays that the turns point into
        self._turns = (_Turn * 0)()
        self._parameters = (ctypes.c_double * 0)()
        self._placed: list[list[str]] = []  # names of these by slave,
        self._whole: list[tuple[int, str]] = []  # of these the whole numbers,
        self._others: list[tuple[int, list[str]]] = []  # and those that are no such numbers

    def _find(self, name: str) -> tuple[str, str]:
        slave, _, variable = name.partition(".")
        if slave not in self.slaves:
            raise InputError(f"{name}: there is no FMU {slave!r}; there are {', '.join(self.slaves)}")
        if fault := untransferable(self.slaves[slave].face, self.slaves[slave].variable(variable)):
            raise InputError(f"{name} {fault}")
        return slave, variable

    def _by_base(self, slave: str, names: Sequence[str]) -> dict[str, list[str]]:
        """Return a slave's variables among names, by what their FMI functions are named by."""
        owner = self.slaves.get(slave)
        groups: dict[str, list[str]] = {}
        for name in names:
            of, _, own = name.partition(".")
            if of == slave:
                self._find(name)
                groups.setdefault(owner.face.types[owner.variable(own).type][0], []).append(own)
        return groups

    def initialize(
        self,
        start_values: Mapping[str, Mapping] | None = None,
        signals: Mapping[str, float] | None = None,
    ) -> None:
        """Initialize all slaves, the first time or again.

        Parameters
        ----------
        start_values : mapping of str to mapping, optional
            Parameters by slave and name.
        signals : mapping of str to float, optional
            What signals are before the first step: inputs get it, and outputs of the slaves before.

        Raises
        ------
        InputError
            If an FMU refuses a value; in its own words.
        """
        self._step = 0
        self._last.fill(0.0)
        for name, value in (signals or {}).items():
            self._last[self._slots[name]] = value
        given = [(start_values or {}).get(name) or {} for name in self.slaves]
        for slave, values in zip(self.slaves.values(), given, strict=True):
            slave.renew(values)
        self._fill(given)
        self._call("reset")
        self._set_parameters(given)
        self._call("start", self._last_courses)

    def _call(self, name: str, *further: object) -> None:
        """Call a function of stepper.c that tells whether all went well."""
        fault = _Fault()
        if not _function(name)(self._turns, len(self._turns), *further, fault):
            raise self._explain(fault, 0.0)

    def _set_parameters(self, given: Sequence[Mapping]) -> None:
        """Put parameters into their places, and set those that have none."""
        numbers = [
            float(values[n]) for values, placed in zip(given, self._placed, strict=True) for n in placed
        ]
        for i, name in self._whole:
            if given[i][name] != round(given[i][name]):
                path, value = list(self.slaves.values())[i].path, given[i][name]
                raise InputError(f"{path}: {name} is {value:g}; it must be a whole number")
        self._parameters[:] = numbers
        for i, others in self._others:
            list(self.slaves.values())[i].set({name: given[i][name] for name in others})

    def _fill(self, given: Sequence[Mapping]) -> None:
        """Fill in what the slaves do, with the addresses that the instances have now."""
        instances = [slave.instance for slave in self.slaves.values()]
        filling = instances, [list(values) for values in given]
        if filling == self._filled:
            return
        self._filled = ()
        self._kept.clear()
        self._turns = (_Turn * len(self.slaves))()
        for i, (name, slave) in enumerate(self.slaves.items()):
            turn, prefix, held = self._turns[i], slave.face.prefix, slave.face.held
            turn.instance, turn.version = slave.instance, slave.face.number
            for member, function in slave.face.functions.items():
                setattr(turn, member, slave.function(f"{prefix}{function}"))
            for base, group in self._inputs[name].items():
                sources = [self._connections[f"{name}.{v}"] for v in group]
                ends = [
                    (c.factor, c.offset, 0, self._slots[c.source], self._made(c, i)) for c in sources
                ]
                plain = all(c.as_it_is for c in sources)
                turn.set[held[base]] = self._transfer(slave, f"{prefix}Set{base}", group, ends, plain)
            for base, group in self._outputs[name].items():
                ends = [(1.0, 0.0, 0, self._slots[f"{name}.{v}"], True) for v in group]
                turn.get[held[base]] = self._transfer(slave, f"{prefix}Get{base}", group, ends, True)
        self._fill_parameters(given)
        self._filled = filling

    def _fill_parameters(self, given: Sequence[Mapping]) -> None:
        """Give parameters places in the turns, where they are numbers that compiled code can set."""
        groups, self._others = [], []
        for i, (name, slave) in enumerate(self.slaves.items()):
            others = [n for n in given[i] if untransferable(slave.face, slave.variable(n))]
            groups.append(self._by_base(name, [f"{name}.{n}" for n in given[i] if n not in others]))
            if others:
                self._others.append((i, others))
        self._placed = [[n for group in by_base.values() for n in group] for by_base in groups]
        self._whole = [
            (i, n)
            for i, (slave, names) in enumerate(zip(self.slaves.values(), self._placed, strict=True))
            for n in names
            if slave.face.types[slave.variable(n).type][1] is int
        ]
        self._parameters = (ctypes.c_double * sum(map(len, self._placed)))()
        place = ctypes.addressof(self._parameters)
        for turn, slave, by_base in zip(self._turns, self.slaves.values(), groups, strict=True):
            for base, group in by_base.items():
                ends = [(1.0, 0.0, place + 8 * i, 0, False) for i in range(len(group))]
                place += 8 * len(group)
                function = f"{slave.face.prefix}Set{base}"
                turn.start[slave.face.held[base]] = self._transfer(slave, function, group, ends, True)

    def _transfer(
        self,
        slave: Slave,
        function: str,
        group: Sequence[str],
        ends: Sequence[tuple],
        plain: bool,
    ) -> _Transfer:
        """Return the call that sets or gets a slave's variables of one base."""
        references = np.array([slave.variable(v).valueReference for v in group], dtype=np.uint32)
        values = (_Value * len(group))(*ends)
        base, _ = slave.face.types[slave.variable(group[0]).type]
        room = np.zeros(len(group), dtype=HELD[slave.face.held[base]])
        self._kept += [references, values, room]
        straight = plain and len(group) == 1 and room.dtype == np.float64
        return _Transfer(
            slave.function(function), references.ctypes.data,
            ctypes.addressof(values), None if straight else room.ctypes.data, len(group),
        )  # fmt: skip

    def _made(self, connection: Connection, i: int) -> bool:
        """Tell whether the source of a slave's input is the output of one that steps before it."""
        slave, dot, _ = connection.source.partition(".")
        return bool(dot) and slave in list(self.slaves)[:i]

    def run(
        self, signals: Mapping[str, np.ndarray], steps: int, step_size: float
    ) -> dict[str, np.ndarray]:
        """Make communication steps; a further call continues where this one ended.

        Parameters
        ----------
        signals : mapping of str to ndarray, shape (steps,)
            Every connected signal at the beginning of every step, in SI units.
        steps : int
            Number of steps.
        step_size : float
            Communication step, s; the same in every call after an initialization.

        Returns
        -------
        dict of str to ndarray, shape (steps,)
            Recorded variables by name, as read at the end of every step.

        Raises
        ------
        InputError
            If an FMU does not complete a step, in its own words; a signal is missing or too short.
        """
        arrays = [self._signal(signals, name, steps) for name in self.signals]
        self._places[:] = [address(array) for array in arrays]
        outputs = np.empty((self._courses.output_count, 1 + steps))
        self._courses.outputs, self._courses.length = address(outputs), 1 + steps
        fault = _Fault()
        done = _function("run")(
            self._turns, len(self._turns), self._courses, self._step, steps, step_size, fault
        )
        self._step += done
        if done < steps:
            raise self._explain(fault, self._step * step_size)
        made, first = outputs[:, 1:], len(arrays)
        return {name: made[self._slots[name] - first] for name in self.recorded}

    @staticmethod
    def _signal(signals: Mapping[str, np.ndarray], name: str, steps: int) -> np.ndarray:
        if name not in signals:
            raise InputError(f"there is no signal {name!r}; there are {', '.join(signals) or 'none'}")
        array = np.ascontiguousarray(signals[name], dtype=np.float64)
        if array.shape != (steps,):
            raise InputError(f"signal {name!r} has shape {array.shape}; it must be ({steps},)")
        return array

    def _explain(self, fault: _Fault, time: float) -> InputError:
        slave = list(self.slaves.values())[fault.slave]
        if fault.status == FATAL:
            slave.abandon()
        prefix = slave.face.prefix
        said = slave.fault(FAILED[fault.kind].format(prefix))
        if fault.kind > _LAST_OF_A_STEP:
            return said
        return InputError(f"{said} ({prefix}{STATUS.get(fault.status, fault.status)} at {time:g} s)")

    @property
    def messages(self) -> list[str]:
        """What the slaves have logged since their initialization, and which of them it was."""
        return [
            f"{named(name, slave.model)}: {message}"
            for name, slave in self.slaves.items()
            for message in slave.messages
        ]


def named(slave: str, model: str) -> str:
    """Return how messages call an instance: by its name, and its model's if it is known."""
    return f"{slave} ({model})" if model else slave
