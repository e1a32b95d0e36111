"""C of an effect of the user's own: a stage as stage.h wants it, from its CasADi expressions.

What depends on the parameters alone is computed once, in `prepare`. Derivatives are CasADi's. The
expressions are written out by what CasADi says of their operations: its own generator writes for
`double`, with helpers of its own in each file, and the core is also compiled for `float`, and joined
into one file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca

from it2hys.errors import InputError
from it2hys.model.effect import Memory, Surroundings
from it2hys.model.own_effect import (
    ENDS,
    OwnEffect,
    symbols_of,
)

_INFIX = {
    ca.OP_ADD: "{} + {}", ca.OP_SUB: "{} - {}", ca.OP_MUL: "{} * {}", ca.OP_DIV: "{} / {}",
    ca.OP_NEG: "-{}", ca.OP_SQ: "{0} * {0}", ca.OP_TWICE: "2 * {}", ca.OP_INV: "1 / {}",
    ca.OP_LT: "(real)({} < {})", ca.OP_LE: "(real)({} <= {})", ca.OP_EQ: "(real)({} == {})",
    ca.OP_NE: "(real)({} != {})", ca.OP_NOT: "(real)({} == 0)",
    ca.OP_AND: "(real)({} != 0 && {} != 0)", ca.OP_OR: "(real)({} != 0 || {} != 0)",
    ca.OP_IF_ELSE_ZERO: "{} != 0 ? {} : 0", ca.OP_SIGN: "(real)(({0} > 0) - ({0} < 0))",
    ca.OP_ASSIGN: "{}",
}  # fmt: skip
_CALLED = {
    ca.OP_EXP: "exp", ca.OP_LOG: "log", ca.OP_POW: "pow", ca.OP_CONSTPOW: "pow", ca.OP_SQRT: "sqrt",
    ca.OP_SIN: "sin", ca.OP_COS: "cos", ca.OP_TAN: "tan", ca.OP_ASIN: "asin", ca.OP_ACOS: "acos",
    ca.OP_ATAN: "atan", ca.OP_FLOOR: "floor", ca.OP_CEIL: "ceil", ca.OP_FMOD: "fmod",
    ca.OP_FABS: "fabs", ca.OP_COPYSIGN: "copysign", ca.OP_ERF: "erf", ca.OP_FMIN: "fmin",
    ca.OP_FMAX: "fmax", ca.OP_SINH: "sinh", ca.OP_COSH: "cosh", ca.OP_TANH: "tanh",
    ca.OP_ASINH: "asinh", ca.OP_ACOSH: "acosh", ca.OP_ATANH: "atanh", ca.OP_ATAN2: "atan2",
    ca.OP_LOG1P: "log1p", ca.OP_EXPM1: "expm1", ca.OP_HYPOT: "hypot", ca.OP_REMAINDER: "remainder",
}  # fmt: skip
_AROUND = "const struct stage_surroundings *around"
_PARAMETERS = "const struct chain_parameters *p"
_CONSTANTS, _STATE = "const void *constants", "const void *state"


def own_stage(effect: OwnEffect) -> dict[str, str]:
    """Return `<effect>.h` and `<effect>.c` of an effect by their names."""
    stage = _Stage(effect)
    return {f"{effect.name}.h": stage.header(), f"{effect.name}.c": stage.source()}


def stages_with(text: str, effects: Sequence[OwnEffect]) -> str:
    """Return `stages.h` with these effects, last on their side in this order."""
    lines = text.splitlines()
    for effect in effects:
        memory, side = effect.memory.name, effect.side.upper()
        row = f"    {memory}({effect.name}, {effect.name.upper()}, {side})"
        last = max(i for i, line in enumerate(lines) if line.rstrip(" \\").endswith(f", {side})"))
        end = " \\" if lines[last].endswith("\\") else ""
        lines[last] = lines[last].rstrip(" \\") + " \\"
        lines.insert(last + 1, row + end)
        include = max(i for i, line in enumerate(lines) if line.startswith('#include "'))
        lines.insert(include + 1, f'#include "{effect.name}.h"')
    return "\n".join(lines) + "\n"


def _literal(value: float) -> str:
    if value != value or value in (float("inf"), float("-inf")):
        return (
            "(REAL_INFINITY - REAL_INFINITY)" if value != value else f"{'-' * (value < 0)}REAL_INFINITY"
        )
    if value == int(value) and abs(value) < 1e6:
        return f"{int(value)}" if value >= 0 else f"({int(value)})"
    return f"REAL({value!r})" if value >= 0 else f"(-REAL({-value!r}))"


class _Stage:
    def __init__(self, effect: OwnEffect) -> None:
        self.effect, self.name = effect, effect.name
        self.n = effect.states
        values, self.s, self.x, around = symbols_of(effect)
        self.around = [ca.SX(a) for a in around]
        ends = {end: ca.SX.sym(end) for end in ENDS[effect.side]}
        self.y = ca.SX.sym("y")
        #: Parameters, and where they are in struct chain_parameters.
        self.p = {**values, **ends}
        output, following = effect.step(values, list(self.s), self.x, around)
        parts = [[output, *following]]
        if effect.inverse_is_given and effect.has_inverse:
            parts.append([effect.inverse(self.p, list(self.s), self.y, around)[0]])
        else:
            parts.append([])
        if effect.rest_is_given:
            x, state = effect.rest(values, self.y)
            parts.append([x, *state])
        else:
            parts.append([])
        parts.append([effect.latency(values)] if effect.latency_is_given else [])
        self._extract(parts)

    def _extract(self, parts: list[list]) -> None:
        """Put symbols in the place of what depends on the parameters alone."""
        p = ca.vertcat(*self.p.values())
        whole, symbols, self.constants = ca.extract_parametric(
            ca.vertcat(*(ca.SX(e) for part in parts for e in part)), p
        )
        self.k = list(symbols)
        self.constants = list(self.constants)
        for own in self.p.values():
            if ca.depends_on(whole, own):  # by itself
                symbol = ca.SX.sym("k")
                whole = ca.substitute(whole, own, symbol)
                self.k.append(symbol)
                self.constants.append(own)
        if not self.k:  # a struct is not empty
            self.k.append(ca.SX.sym("k"))
            self.constants.append(next(iter(self.p.values())))
        rows, place = ca.vertsplit(whole), 0
        found = []
        for part in parts:
            found.append(rows[place : place + len(part)])
            place += len(part)
        self.outputs, self.given_inverse, self.given_rest, self.latency = found

    # --- text ---------------------------------------------------------------------------------------

    def header(self) -> str:
        """Return the header."""
        name, guard = self.name, f"IT2HYS_OWN_{self.name.upper()}_H"
        members = [
            f"    real {q.name}; /* {q.unit.replace('*/', '* /')} */" for q in self.effect.parameters
        ]
        state = ["", f"struct {name}_state {{", f"    real s[{self.n}];", "};"] if self.n else []
        return "\n".join(
            [
                f"/* Generated from {self.effect.file.name}, SHA-256 {self.effect.digest}. */",
                f"#ifndef {guard}",
                f"#define {guard}",
                "",
                '#include "own_stage.h"',
                "",
                f"typedef struct {name}_parameters {{",
                *members,
                f"}} {name}_parameters;",
                "",
                f"struct {name} {{",
                f"    real k[{len(self.k)}]; /* of the parameters alone */",
                "    real low, high; /* the range in which the input is sought, without derivatives */",
                "};",
                *state,
                "",
                "HIDDEN_BEGIN",
                f"extern const struct stage {name}_stage;",
                f"extern const struct stage_analysis {name}_analysis;",
                "HIDDEN_END",
                "",
                "#endif",
                "",
            ]
        )

    def source(self) -> str:
        """Return the source."""
        effect, name = self.effect, self.name
        parts = [
            f'/* Generated from {effect.file.name}. */\n#include "{name}.h"\n\n#include "chain.h"\n',
            self._is_on(),
            self._prepare(),
            self._step(),
        ]
        stage = [f".is_on = {name}_is_on", f".prepare = {name}_prepare", f".step = {name}_step"]
        analysis = [f".prepare_tangent = {name}_prepare_tangent", f".tangent = {name}_tangent"]
        if effect.side != "reading":
            parts += [self._curve(), self._rest()]
            stage.append(f".rest = {name}_rest")
        if effect.has_inverse:
            parts += [self._inverse(), self._check()]
            stage.append(f".inverse = {name}_inverse")
            analysis += [f".inverse_tangent = {name}_inverse_tangent", f".check = {name}_check"]
        if effect.latency_is_given:
            parts.append(self._latency())
            stage.append(f".latency = {name}_latency")
        parts += [self._prepare_tangent(), self._tangent(), self._by_parameters()]
        analysis.append(f".by_parameters = {name}_by_parameters")
        if effect.side != "reading":
            parts.append(self._rest_tangent())
            analysis.append(f".rest_tangent = {name}_rest_tangent")
        if effect.has_inverse:
            parts.append(self._inverse_tangent())
        for kind, entries in (("stage", stage), ("stage_analysis", analysis)):
            text = "".join(f"    {entry},\n" for entry in entries)
            parts.append(f"const struct {kind} {name}_{kind.removeprefix('stage_')} = {{\n{text}}};\n")
        return "\n".join(parts)

    def _function(self, head: str, *body: str | Sequence[str]) -> str:
        lines = [line for part in body for line in ([part] if isinstance(part, str) else part)]
        return f"static {head}\n{{\n" + "".join(f"    {line}".rstrip() + "\n" for line in lines) + "}\n"

    def _computed(
        self,
        expressions: Sequence[ca.SX],
        more: Mapping[str, ca.SX] | None = None,
        at_rest: bool = False,
    ) -> tuple[list[str], list[str]]:
        """Return C statements that compute expressions, and what the results are called."""
        around = "OWN_AT_REST." if at_rest else "around->"
        inputs = {
            **{f"c->k[{i}]": k for i, k in enumerate(self.k)},
            **{f"s[{i}]": s for i, s in enumerate(self.s)},
            "x": self.x,
            "y": self.y,
            **{around + n: a for n, a in zip(Surroundings._fields, self.around, strict=True)},
            **(more or {}),
        }
        return statements(expressions, inputs, self.effect)

    def _is_on(self) -> str:
        return self._function(
            f"bool {self.name}_is_on({_PARAMETERS})",
            f"return p->{self.effect.switch} != 0;",
        )

    def _prepare(self) -> str:
        body, results = statements(
            self.constants, {f"p->{n}": s for n, s in self.p.items()}, self.effect
        )
        low, high = (f"p->{end}" for end in ENDS[self.effect.side])
        return self._function(
            f"void {self.name}_prepare(void *constants, {_PARAMETERS})",
            f"struct {self.name} *c = constants;",
            "",
            body,
            [f"c->k[{i}] = {r};" for i, r in enumerate(results)],
            f"c->low = {low};",
            f"c->high = {high};",
        )

    def _prepare_tangent(self) -> str:
        p = {n: s for n, s in self.p.items() if n != "sampleTime"}
        d = {n: ca.SX.sym(f"d_{n}") for n in p}
        constants = ca.vertcat(*self.constants)
        along = ca.jtimes(constants, ca.vertcat(*p.values()), ca.vertcat(*d.values()))
        body, results = statements(
            ca.vertsplit(along),
            {**{f"p->{n}": s for n, s in self.p.items()}, **{f"d->{n}": s for n, s in d.items()}},
            self.effect,
        )
        return self._function(
            f"void {self.name}_prepare_tangent(void *d_constants, {_CONSTANTS}, {_PARAMETERS}, "
            "const struct chain_parameters *d)",
            f"struct {self.name} *result = d_constants;",
            "",
            "(void)constants, (void)p, (void)d;",
            body,
            [f"result->k[{i}] = {r};" for i, r in enumerate(results)],
        )

    def _reads(self, *more: str) -> list[str]:
        """Return the declarations of constants and state that are read, and of more that may be."""
        lines = [f"const struct {self.name} *c = constants;"]
        if self.n:
            lines.append(f"const real *s = ((const struct {self.name}_state *)state)->s;")
        pointers = [
            "c",
            "state",
            *["s"] * bool(self.n),
            *(line.split(" = ")[0].split("*")[1] for line in more),
        ]
        return [*lines, *more, "", ", ".join(f"(void){p}" for p in pointers) + ";"]

    def _step(self) -> str:
        body, (output, *following) = self._computed(self.outputs)
        to = f"((struct {self.name}_state *)state)->s"
        return self._function(
            f"real {self.name}_step({_CONSTANTS}, void *state, real x, {_AROUND})",
            self._reads(),
            "(void)x, (void)around;",
            body,
            # before any state is written: a result may be one
            [f"const real output = {output};"],
            [f"const real next{i} = {r};" for i, r in enumerate(following)],
            [f"{to}[{i}] = next{i};" for i in range(self.n)],
            "return output;",
        )

    def _curve(self) -> str:
        slope = ca.jacobian(self.outputs[0], self.x)
        body, results = self._computed([self.outputs[0], slope])
        return self._function(
            f"real {self.name}_curve({_CONSTANTS}, {_STATE}, real x, {_AROUND}, real *slope)",
            self._reads(),
            "(void)x, (void)around;",
            body,
            f"*slope = {results[1]};",
            f"return {results[0]};",
        )

    def _inverse(self) -> str:
        name = self.name
        affine = not ca.depends_on(ca.jacobian(self.outputs[0], self.x), self.x)
        if self.given_inverse:
            body, (result,) = self._computed(self.given_inverse)
        elif affine:
            slope = ca.jacobian(self.outputs[0], self.x)
            at = ca.substitute(self.outputs[0], self.x, self.y)
            body, (result,) = self._computed([self.y - (at - self.y) / slope])
        else:
            body = []
            result = f"own_search({name}_curve, constants, state, y, around, c->low, c->high)"
        advanced = [f"{name}_step(constants, state, x, around);"] * (self.effect.memory is Memory.AIMED)
        return self._function(
            f"real {name}_inverse({_CONSTANTS}, void *state, real y, {_AROUND})",
            self._reads(),
            "if (!around) /* what holds the chain at rest */",
            "    around = &OWN_AT_REST;",
            body,
            f"const real x = {result};",
            advanced,
            "return x;",
        )

    def _rest(self) -> str:
        """From (y, 0) by Newton's method, unless the file says where."""
        name, n = self.name, self.n
        head = f"real {name}_rest({_CONSTANTS}, void *state, real y, {_PARAMETERS})"
        reads = [f"const struct {name} *c = constants;"]
        writes = f"((struct {name}_state *)state)->s"
        begin = ["", "(void)c, (void)state, (void)p;"]
        if self.given_rest:
            body, (x, *state) = self._computed(self.given_rest)
            return self._function(
                head, reads, begin, body, [f"{writes}[{i}] = {r};" for i, r in enumerate(state)],
                f"return {x};",
            )  # fmt: skip
        steps = self.effect.rest_steps
        if steps == 0:
            return self._function(
                head, reads, begin, [f"{writes}[{i}] = 0;" for i in range(n)], "return y;"
            )
        if not n:
            everywhere = "&OWN_AT_REST, -REAL_INFINITY, REAL_INFINITY"
            return self._function(
                head, reads, begin, f"return own_search({name}_curve, c, NULL, y, {everywhere});"
            )
        body, results = self._computed(self._rest_step(), at_rest=True)
        return self._function(
            head,
            reads,
            [f"real s[{n}] = {{ 0 }};"] * bool(n),
            "real x = y;",
            begin,
            f"for (int i = 0; i < {steps}; i++) {{",
            [f"    {line}" for line in body],
            [f"    const real to{i} = {r};" for i, r in enumerate(results)],
            "    x = to0;",
            [f"    s[{i}] = to{i + 1};" for i in range(n)],
            "}",
            [f"{writes}[{i}] = s[{i}];" for i in range(n)],
            "return x;",
        )

    def _rest_step(self) -> list[ca.SX]:
        """Return input and states one Newton step nearer to rest; as rest_step of own_effect.py."""
        at = ca.vertcat(self.x, *self.s)
        output, *following = self.outputs
        excess = ca.vertcat(output - self.y, *(a - b for a, b in zip(following, self.s, strict=True)))
        return ca.vertsplit(at - ca.solve(ca.jacobian(excess, at), excess))

    def _rest_tangent(self) -> str:
        name, n = self.name, self.n
        y, d_y = self.y, ca.SX.sym("d_y")
        dk = [ca.SX.sym("dk") for _ in self.k]
        if self.given_rest:
            rested = self.given_rest
        elif self.effect.rest_steps == 0:
            rested = [y, *[ca.SX(0)] * n]
        else:
            rested = self._rest_step()
        # where it rests, a Newton step leaves derivatives by where it began at 0
        by = ca.vertcat(y, *self.k)
        along = ca.jtimes(ca.vertcat(*rested), by, ca.vertcat(d_y, *dk))
        more = {"d_y": d_y, **{f"d->k[{i}]": k for i, k in enumerate(dk)}}
        body, (d_x, *d_state) = self._computed(ca.vertsplit(along), more, at_rest=True)
        found = []
        if ca.depends_on(along, y):
            there = f"{name}_curve(constants, state, x, &OWN_AT_REST, &slope)"
            found = ["real slope;", f"const real y = {there};"]
        return self._function(
            f"real {name}_rest_tangent({_CONSTANTS}, const void *d_constants, {_STATE}, "
            f"void *d_state, real x, real d_y, {_PARAMETERS}, const struct chain_parameters *d_p)",
            self._reads(f"const struct {name} *d = d_constants;"),
            "(void)d_state, (void)x, (void)d_y, (void)p, (void)d_p;",
            found,
            body,
            [f"((struct {name}_state *)d_state)->s[{i}] = {r};" for i, r in enumerate(d_state)],
            f"return {d_x};",
        )

    def _check(self) -> str:
        """Return the check that the output rises with the input, at rest all over the range."""
        name, n = self.name, self.n
        state = f"struct {name}_state state;" if n else []
        at = "&state" if n else "NULL"
        first = self.effect.switch
        return self._function(
            f"bool {name}_check({_PARAMETERS}, char *message, size_t size)",
            f"struct {name} c;",
            state,
            "real slope;",
            "",
            f"if (!{name}_is_on(p))",
            "    return true;",
            f"{name}_prepare(&c, p);",
            "for (int i = 0; i <= OWN_GRID; i++) {",
            "    const real place = c.low + (c.high - c.low) * (real)i / OWN_GRID;",
            f"    const real x = {f'{name}_rest(&c, {at}, place, p)' if n else 'place'};",
            "    if (x < c.low || x > c.high)",
            "        continue;",
            f"    const real there = {name}_curve(&c, {at}, x, &OWN_AT_REST, &slope);",
            "    if (!(slope > 0 && slope < REAL_MAX && real_fabs(there) < REAL_MAX))",
            "        return refuse(message, size,",
            f'                      "with {first} = %g, the output of {name} does not rise with its "',
            '                      "input at rest at %g, so that it has no inverse",',
            f"                      (double)p->{first}, (double)x);",
            "}",
            "return true;",
        )

    def _latency(self) -> str:
        body, (result,) = self._computed(self.latency)
        return self._function(
            f"real {self.name}_latency({_CONSTANTS})",
            f"const struct {self.name} *c = constants;",
            "",
            "(void)c;",
            body,
            f"return {result};",
        )

    def _tangent(self) -> str:
        """By state, input and surroundings: the matrix once, then all columns."""
        matrix = ca.jacobian(ca.vertcat(*self.outputs), ca.vertcat(self.x, *self.s, *self.around))
        there = [
            (i, j) for i in range(matrix.rows()) for j in range(matrix.columns()) if matrix.has_nz(i, j)
        ]
        body, results = self._computed([matrix[i, j] for i, j in there])
        terms: list[list[str]] = [[] for _ in range(self.n + 1)]
        names = []
        for (i, j), result in zip(there, results, strict=True):
            names.append(f"const real j{i}_{j} = {result};")
            terms[i].append(f"j{i}_{j} * d{j}")
        places = ["row[i]", *(f"d_state[{j} * count + i]" for j in range(self.n))]
        along = [*places, *(f"d_around[i].{name}" for name in Surroundings._fields)]
        used = sorted({j for _, j in there})
        return self._function(
            f"void {self.name}_tangent({_CONSTANTS}, {_STATE}, real x, {_AROUND}, "
            f"const struct stage_surroundings *d_around, int count, real *restrict d_state, "
            "real *restrict row)",
            self._reads(),
            "(void)x, (void)around, (void)d_around, (void)d_state;",
            body,
            names,
            "for (int i = 0; i < count; i++) {",
            [f"    const real d{j} = {along[j]};" for j in used],
            [
                f"    {place} = {' + '.join(own) or '0'};"
                for place, own in zip(places, terms, strict=True)
            ],
            "}",
        )

    def _by_parameters(self) -> str:
        dk = [ca.SX.sym("dk") for _ in self.k]
        along = ca.jtimes(ca.vertcat(*self.outputs), ca.vertcat(*self.k), ca.vertcat(*dk))
        body, (d_y, *d_state) = self._computed(
            ca.vertsplit(along), {f"d->k[{i}]": k for i, k in enumerate(dk)}
        )
        return self._function(
            f"real {self.name}_by_parameters({_CONSTANTS}, const void *d_constants, "
            f"{_STATE}, real x, {_AROUND}, real *d_state, int stride)",
            self._reads(f"const struct {self.name} *d = d_constants;"),
            "(void)x, (void)around, (void)d_state, (void)stride;",
            body,
            [f"d_state[{i} * stride] += {r};" for i, r in enumerate(d_state) if r != "0"],
            f"return {d_y};",
        )

    def _inverse_tangent(self) -> str:
        """From y = f(s, x, around): dx = (dy - df/ds ds - df/da da) / (df/dx)."""
        name, n = self.name, self.n
        d_y, d_s = ca.SX.sym("d_y"), [ca.SX.sym("d") for _ in self.s]
        d_around = [ca.SX.sym(f"d_{a}") for a in self.around]
        outputs = ca.vertcat(*self.outputs)
        held, along = ca.vertcat(*self.s, *self.around), ca.vertcat(*d_s, *d_around)
        by_held = ca.jtimes(outputs, held, along)
        slopes = ca.jacobian(outputs, self.x)
        d_x = (d_y - by_held[0]) / slopes[0]
        searched = not self.given_inverse and ca.depends_on(slopes[0], self.x)
        more = {
            "d_y": d_y,
            **{f"d_s->s[{i}]": d for i, d in enumerate(d_s)},
            **{f"d_around->{m}": a for m, a in zip(Surroundings._fields, d_around, strict=True)},
        }
        head = (
            f"real {name}_inverse_tangent({_CONSTANTS}, {_STATE}, real x, void *d_state, "
            f"real d_y, {_AROUND}, const struct stage_surroundings *d_around)"
        )
        aimed = self.effect.memory is Memory.AIMED
        body, (d_x_text,) = self._computed([d_x], more)
        advance = [f"{name}_tangent(constants, state, x, around, d_around, 1, d_s->s, &row);"] * aimed
        return self._function(
            head,
            self._reads(*([f"struct {name}_state *d_s = d_state;"] * bool(n))),
            "(void)x, (void)around, (void)d_around, (void)d_state;",
            body,
            f"const real moved = {d_x_text};",
            ["real row;"] * aimed,
            # as far beyond the range as it is sought it stays
            [
                "const real beyond = own_beyond(c->low, c->high);",
                "const real d_x = x <= c->low - beyond || x >= c->high + beyond ? 0 : moved;",
            ]
            if searched
            else "const real d_x = moved;",
            ["row = d_x;"] * aimed,
            advance,
            "return d_x;",
        )


def statements(
    expressions: Sequence[ca.SX], inputs: Mapping[str, ca.SX], effect: OwnEffect
) -> tuple[list[str], list[str]]:
    """Return C statements that compute expressions, and the names or numbers that they come to.

    Parameters
    ----------
    expressions : sequence of casadi.SX
    inputs : mapping
        Symbols by what they are called in C.
    effect : OwnEffect
        For what is said where C has no such operation.
    """
    names = list(inputs)
    together = ca.cse(ca.densify(ca.vertcat(*(ca.SX(e) for e in expressions))))
    function = ca.Function("f", [ca.vertcat(*inputs.values())], [together])
    lines: list[str] = []
    at: dict[int, str] = {}  # what each place of the work vector holds
    results = ["0"] * len(expressions)
    for i in range(function.n_instructions()):
        operation = function.instruction_id(i)
        get, put = function.instruction_input(i), function.instruction_output(i)
        if operation == ca.OP_INPUT:
            at[put[0]] = names[get[1]]
        elif operation == ca.OP_OUTPUT:
            results[put[1]] = at[get[0]]
        elif operation == ca.OP_CONST:
            at[put[0]] = _literal(function.instruction_constant(i))
        else:
            arguments = [at[g] for g in get]
            if operation in _INFIX:
                text = _INFIX[operation].format(*arguments)
            elif operation in _CALLED:
                text = f"REAL_FUNCTION({_CALLED[operation]})({', '.join(arguments)})"
            else:
                raise InputError(f"{effect.file}:1: {effect.name} uses an operation that C lacks")
            lines.append(f"const real a{len(lines)} = {text};")
            at[put[0]] = f"a{len(lines) - 1}"
    return lines, results
