"""The chain with its effects in single precision, as one C header made from the core's sources.

There is one text of every equation: what is in double becomes float, with names of its own, so that
both forms can be in one program. The IT2 core is that of `it2_single.h`, whose exponentials are made
for it. Only the standard library is used, because the C build runs this.
"""

import re
import sys
from pathlib import Path

# the list of stages
LISTED = re.compile(r"^    [A-Z]+\((\w+), [A-Z]+, [A-Z]+\)", re.MULTILINE)
# the core's operations, and the structs that go with them
CORE = {
    "it2_prepare": "it2_single_prepare",
    "it2_reset": "it2_single_reset",
    "it2_step": "it2_single_advance",
    "it2_inverse": "it2_single_retrace",
    "it2_solve": "it2_single_inverse",
    "struct it2": "struct it2_single",
    "struct it2_state": "struct it2_single_state",
    "struct it2_range": "struct it2_single_range",
}
# checks explain in words, which is for hosts; derivatives are for those with time
LEFT_OUT = re.compile(r"\w*(_check|_tangent|_derivative|_by_parameters|_analysis|refuse)")
MATH = ("fmin", "fmax", "fabs", "floor", "exp", "expm1", "sin", "cos", "sqrt")

_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_HEAD = r"^(?:static )?(?:inline )?(?:const )?(?:struct )?\w+ \**(?P<name>\w+)\([^;{}]*\)"
_FUNCTION = re.compile(_HEAD + r"\n\{\n.*?^\}\n", re.MULTILINE | re.DOTALL)
_PROTOTYPE = re.compile(_HEAD + r";\n", re.MULTILINE)
_ANALYSIS = re.compile(r"^(?:extern )?const struct stage_analysis\b[^;]*;\n", re.MULTILINE)
_OBJECT = re.compile(r"^(?:extern )?(const struct \w+ \w+)", re.MULTILINE)
_FLOAT = re.compile(r"(?<![\w.])((?:\d+\.\d*|\.\d+)(?:[eE][-+]?\d+)?|\d+[eE][-+]?\d+)(?![\w.])")


def single_precision(folder: Path) -> str:
    """Return the C text of the chain in single precision.

    Parameters
    ----------
    folder : Path
        Of the core's sources: fmu_src/core.

    Returns
    -------
    str
        Types and functions, all static, with names that begin with ``single_``.
    """
    stages = [*LISTED.findall((folder / "stages.h").read_text(encoding="utf-8")), "chain"]
    names = [
        "stage.h", *(f"{stage}.h" for stage in stages[:-1]), "stages.h", "chain.h",
        *(f"{stage}.c" for stage in stages),
    ]  # fmt: skip
    texts = [_without_comments((folder / name).read_text(encoding="utf-8")) for name in names]
    return "\n".join(filter(None, (_in_single_precision(text, [*stages, "stage"]) for text in texts)))


def with_float_literals(text: str) -> str:
    """Return C text with all floating-point literals in single precision."""
    return _FLOAT.sub(r"\1f", text)


def _without_comments(text: str) -> str:
    return _COMMENT.sub("", text)


def _in_single_precision(text: str, stages: list[str]) -> str:
    text = re.sub(r"^#(?:include|ifndef|endif|define IT2HYS_).*\n", "", text, flags=re.MULTILINE)
    text = re.sub(r"^HIDDEN_(?:BEGIN|END)\n", "", text, flags=re.MULTILINE)
    text = _ANALYSIS.sub("", text)
    text = _OBJECT.sub(r"static \1", text)
    text = re.sub(r"(struct )?name##", r"\1single_##name##", text)
    text = text.replace("struct name", "struct single_##name")
    text = _FUNCTION.sub(_inlined, text)
    text = _PROTOTYPE.sub(_inlined, text)
    for name, single in CORE.items():
        text = re.sub(rf"\b{name}\b", single, text)
    own = "|".join(stages)
    text = re.sub(rf"\b({own})_(?=\w)", r"single_\1_", text)
    text = re.sub(rf"\b((?:struct|enum) )({own})\b", r"\1single_\2", text)
    text = re.sub(rf"\b({own.upper()}|TWO_PI)(?=_[\w#]|\b)", r"SINGLE_\1", text)
    text = re.sub(r"\bclamp\(", "single_clamp(", text)
    text = re.sub(r"\bdouble\b", "float", text)
    text = re.sub(r"\bDBL_EPSILON\b", "FLT_EPSILON", text)
    text = re.sub(rf"\b({'|'.join(MATH)})\(", r"\1f(", text)
    text = re.sub(r"[ \t]+$", "", with_float_literals(text), flags=re.MULTILINE)
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n" if text.strip() else ""


def _inlined(match: re.Match) -> str:
    if LEFT_OUT.fullmatch(match["name"]):
        return ""
    return "static inline " + re.sub(r"^(static )?(inline )?", "", match[0])


if __name__ == "__main__":  # the C build: from fmu_src/core to a file of the package
    Path(sys.argv[2]).write_text(single_precision(Path(sys.argv[1])), encoding="utf-8", newline="\n")
