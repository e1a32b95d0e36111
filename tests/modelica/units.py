"""Units of the library's equations, as far as the declared ones tell: a Modelica tool's unit check.

A unit is the exponents of kg, m, s, A and K. What has no declared unit is unknown and fits everything;
a number fits everything in a sum, and is dimensionless in a product.
"""

import re
from collections.abc import Iterator
from fractions import Fraction

from library import CLASSES, kind

Unit = tuple[Fraction, ...]
SYMBOLS: dict[str, tuple[int, ...]] = {
    "1": (0, 0, 0, 0, 0),
    "rad": (0, 0, 0, 0, 0),
    "kg": (1, 0, 0, 0, 0),
    "m": (0, 1, 0, 0, 0),
    "s": (0, 0, 1, 0, 0),
    "A": (0, 0, 0, 1, 0),
    "K": (0, 0, 0, 0, 1),
    "Hz": (0, 0, -1, 0, 0),
    "N": (1, 1, -2, 0, 0),
    "J": (1, 2, -2, 0, 0),
    "W": (1, 2, -3, 0, 0),
    "C": (0, 0, 1, 1, 0),
    "V": (1, 2, -3, -1, 0),
    "F": (-1, -2, 4, 2, 0),
    "Ohm": (1, 2, -3, -2, 0),
    "S": (-1, -2, 3, 2, 0),
}
NUMBER = "number"
NONE = (Fraction(0),) * 5
SUMS = {"Add", "Sub", "AddElem", "SubElem", "Lt", "Le", "Gt", "Ge", "Eq", "Neq"}
SAME = {"Pre", "Abs", "Max", "Min", "Sum", "NoEvent", "Smooth"}
OF_NUMBERS = {"Exp", "Sin", "Cos", "Sinh", "Log"}
#: Units of the types that the library declares functions' arguments with.
TYPES = {
    "Length": "m",
    "Voltage": "V",
    "ElectricPotential": "V",
    "Time": "s",
    "Force": "N",
    "Frequency": "Hz",
    "Temperature": "K",
    "Angle": "rad",
}


def parsed(text: str | None) -> Unit | None:
    """Return the exponents of a unit in Modelica's notation, or None for none."""
    if not text:
        return None
    above, _, below = text.partition("/")
    total = [Fraction(0)] * 5
    for side, part in ((1, above), (-1, below.strip("()"))):
        for symbol, power in re.findall(r"(1|[A-Za-z]+)(-?\d*)", part):
            for i, exponent in enumerate(SYMBOLS[symbol]):
                total[i] += side * exponent * int(power or 1)
    return tuple(total)


DECLARED = re.compile(
    r"^ +(input|output) (?:[\w.]+\.)?(\w+) (\w+)(?:\[[^\]]*\])?(?:\(([^;]*?)\))?(?: \"|=)",
    re.M,
)


def of_function(name: str) -> dict[str, Unit | None]:
    """Return the units of a function's inputs and then its outputs, as its source declares them."""
    text = CLASSES[name].read_text(encoding="utf-8")
    found = {}
    for _, kind_of, argument, attributes in DECLARED.findall(text):
        given = re.search(r'unit="([^"]*)"', attributes or "")
        found[argument] = parsed(given[1] if given else TYPES.get(kind_of))
    return found


FUNCTIONS = {name: of_function(name) for name in CLASSES if kind(name) == "function"}
OUTPUTS = {
    name: [
        d[2] for d in DECLARED.findall(CLASSES[name].read_text(encoding="utf-8")) if d[0] == "output"
    ]
    for name in FUNCTIONS
}


class Checker:
    """Walks the expressions of a flat model, and keeps what does not fit."""

    def __init__(self, units: dict[str, Unit | None]):
        self.units, self.faults, self.where = units, [], ""

    def joined(self, *units: Unit | str | None) -> Unit | str | None:
        """Return the one unit of terms that must have the same."""
        known = {u for u in units if u is not None and u != NUMBER}
        if len(known) > 1:
            self.faults.append(f"{self.where}: {' and '.join(sorted(map(written, known)))}")
            return None
        if None in units and not known:
            return None
        return known.pop() if known else NUMBER

    def unit(self, x: dict) -> Unit | str | None:
        """Return the unit of an expression, of one kind and its content."""
        ((what, content),) = ((k, v) for k, v in x.items() if k[:1].isupper())
        return getattr(self, what.lower(), self.unknown)(content)

    def unknown(self, content: object) -> None:
        """Of what no unit is known, look at what it holds."""
        for inner in expressions(content):
            self.unit(inner)

    def literal(self, content: dict) -> str:
        return NUMBER

    def varref(self, content: dict) -> Unit | None:
        return self.units.get(content["name"]["name"])

    def index(self, content: dict) -> Unit | str | None:
        return self.unit(content["base"])

    def unary(self, content: dict) -> Unit | str | None:
        return self.unit(content["rhs"])

    def array(self, content: dict) -> Unit | str | None:
        found = {self.unit(x) for x in content["elements"]}
        return found.pop() if len(found) == 1 else None

    def binary(self, content: dict) -> Unit | str | None:
        left, right, op = self.unit(content["lhs"]), self.unit(content["rhs"]), content["op"]
        if op in SUMS:
            return self.joined(left, right)
        if op in ("And", "Or") or left is None or right is None:
            return None
        if op == "Exp":
            power = content["rhs"].get("Literal", {}).get("value", {}).get("Integer")
            return left if left == NUMBER or power is None else tuple(power * u for u in left)
        sign = -1 if op.startswith("Div") else 1
        pairs = zip(*(NONE if u == NUMBER else u for u in (left, right)), strict=True)
        return NUMBER if left == right == NUMBER else tuple(a + sign * b for a, b in pairs)

    def builtincall(self, content: dict) -> Unit | str | None:
        name, units = content["function"], [self.unit(x) for x in content["args"]]
        if name in SAME:
            return self.joined(*units)
        if name == "Fill":
            return units[0]
        if name == "Der" and units[0] not in (None, NUMBER):
            return tuple(u - s for u, s in zip(units[0], parsed("s"), strict=True))
        if name == "Sqrt" and units[0] not in (None, NUMBER):
            return tuple(u / 2 for u in units[0])
        if name in OF_NUMBERS:
            self.joined(NONE, *units)
            return NONE
        return None

    def functioncall(self, content: dict) -> Unit | None:
        name = (content.get("name") or content.get("comp"))["name"]
        units = [self.unit(x) for x in content["args"]]
        if name not in FUNCTIONS:
            return None
        for (argument, wanted), given in zip(FUNCTIONS[name].items(), units, strict=False):
            before, self.where = self.where, f"{self.where}, {argument} of {name}"
            self.joined(wanted, given)
            self.where = before
        return FUNCTIONS[name][OUTPUTS[name][0]] if OUTPUTS[name] else None

    def __getattr__(self, name: str):
        if name == "if":
            return self.condition
        raise AttributeError(name)

    def condition(self, content: dict) -> Unit | str | None:
        if "branches" not in content:
            return self.unknown(content)
        for test, _ in content["branches"]:
            self.unit(test)
        return self.joined(
            *(self.unit(value) for _, value in content["branches"]), self.unit(content["else_branch"])
        )

    def assign(self, content: dict) -> None:
        self.where = content["target"]
        self.joined(self.units.get(content["target"]), self.unit(content["value"]))

    def assignment(self, content: dict) -> None:
        self.where = ".".join(part["ident"] for part in content["comp"]["parts"])
        self.joined(self.units.get(self.where), self.unit(content["value"]))


def written(unit: Unit) -> str:
    """Return a unit for people."""
    names = ("kg", "m", "s", "A", "K")
    return ".".join(f"{n}{u}" for n, u in zip(names, unit, strict=True) if u) or "1"


def expressions(content: object) -> Iterator[dict]:
    """Yield the outermost expressions and statements that something holds."""
    if isinstance(content, dict):
        if sum(k[:1].isupper() for k in content) == 1 and len(content) <= 2:
            yield content
        else:
            for inner in content.values():
                yield from expressions(inner)
    elif isinstance(content, list):
        for inner in content:
            yield from expressions(inner)


def faults(flat: dict) -> list[str]:
    """Return where units do not fit in a flat model: equations, bindings, starts, events, functions."""
    variables = flat["variables"]
    checker = Checker(
        {name: parsed(v["unit"]) for name, v in variables.items()} | {"time": parsed("s")}
    )
    for name, variable in variables.items():
        for value in (variable["binding"], variable["start"]):
            if value:
                checker.where = name
                checker.joined(checker.units[name], checker.unit(value))
    for equation in flat["equations"] + flat["initial_equations"]:
        checker.where = str(equation.get("origin"))
        checker.unit(equation["residual"])
    for what in ("when_chains", "algorithms", "initial_algorithms", "assert_equations"):
        for content in expressions(flat[what]):
            checker.where = what
            checker.unit(content)
    found = checker.faults
    for name, function in flat["functions"].items():
        # what is external C has another body in the overlay
        if name in FUNCTIONS and 'external"C"' not in CLASSES[name].read_text(encoding="utf-8"):
            inside = Checker(dict(FUNCTIONS[name]))
            for content in expressions(function["body"]):
                inside.where = name
                inside.unit(content)
            found += [f"{name}: {fault}" for fault in inside.faults]
    return found
