"""Formulas as MathML, which browsers show by themselves: the site needs no network."""

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml


def _inline(writer: object, node: nodes.math) -> None:
    writer.body.append(tex2mathml(node.astext()))  # type: ignore[attr-defined]
    raise nodes.SkipNode


def _display(writer: object, node: nodes.math_block) -> None:
    formula = tex2mathml(node.astext(), as_block=True)
    writer.body.append(f'<div class="math">{formula}</div>')  # type: ignore[attr-defined]
    raise nodes.SkipNode


def setup(app: object) -> dict:
    """Register the renderer; `html_math_renderer` chooses it."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))  # type: ignore[attr-defined]
    return {"parallel_read_safe": True}
