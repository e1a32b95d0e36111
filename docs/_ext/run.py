"""The directive `run`: code of a page that is executed when the site is built, with what it prints.

    ```{run} sh
    it2hys build -o out
    ```

All blocks of a page share a folder, which is empty at first, and those in Python share their names.
`:hide:` shows only what comes out. A Python block that leaves a matplotlib figure in `figure` shows it.
A block that fails ends the build; one that has `:fails:` must fail, with this exit code.
"""

import io
import os
import shutil
import subprocess
import sys
import traceback
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).parents[2]
#: Lines of output that a page shows of a block.
LINES = 40


class Run(SphinxDirective):
    """Execute a block, and show it with what it prints."""

    required_arguments = 1
    has_content = True
    option_spec = {  # noqa: RUF012 (as docutils has it)
        "hide": directives.flag,
        "fails": directives.nonnegative_int,
        "lines": directives.positive_int,
    }

    def run(self) -> list[nodes.Node]:
        """Return the nodes of the page."""
        language, code = self.arguments[0], "\n".join(self.content)
        page = self._page()
        run = {"sh": _run_shell, "python": _run_python}[language]
        status, printed = run(code, page)
        if status != self.options.get("fails", 0):
            raise self.severe(f"this block ended with {status}:\n{code}\n{printed}")
        shown = []
        if "hide" not in self.options:
            highlighted = {"sh": "bash"}.get(language, language)
            shown.append(nodes.literal_block(code, code, language=highlighted))
        if printed.strip():
            text = self._shortened(printed.rstrip())
            shown.append(nodes.literal_block(text, text, language="text", classes=["output"]))
        if (figure := page["names"].pop("figure", None)) is not None:
            shown.append(self._picture(figure, page))
        return shown

    def _page(self) -> dict:
        """Return what the blocks of this page share."""
        pages = self.env.temp_data.setdefault("run", {})
        if not pages:
            folder = Path(self.env.app.outdir).parent / "run" / self.env.docname.replace("/", "_")
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            pages.update(folder=folder, names={"__name__": "__main__"}, figures=0)
        return pages

    def _shortened(self, text: str) -> str:
        lines, most = text.splitlines(), self.options.get("lines", LINES)
        return "\n".join(lines if len(lines) <= most else [*lines[:most], "…"])

    def _picture(self, figure: object, page: dict) -> nodes.Node:
        page["figures"] += 1
        name = f"{self.env.docname.replace('/', '_')}_{page['figures']}.png"
        folder = Path(self.env.srcdir) / "_generated"
        folder.mkdir(exist_ok=True)
        figure.savefig(folder / name, dpi=140, bbox_inches="tight")  # type: ignore[attr-defined]
        uri = f"/_generated/{name}"
        return nodes.image(uri=uri, alt="Figure drawn by the code above", candidates={"*": uri})


def _environment() -> dict[str, str]:
    """Return variables by which `it2hys` is found, wherever this Python has it from."""
    programs = Path(sys.executable).parent
    paths = [str(ROOT / "python"), *sys.path]
    return {
        **os.environ,
        "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": os.pathsep.join(p for p in paths if p),
        "OMP_NUM_THREADS": "1",
    }


def _run_shell(code: str, page: dict) -> tuple[int, str]:
    begin = f'it2hys() {{ "{sys.executable}" -m it2hys "$@"; }}; set -e\n'
    done = subprocess.run(
        ["bash", "-c", begin + code], cwd=page["folder"], env=_environment(), text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout.replace(f"{page['folder']}/", "")


def _run_python(code: str, page: dict) -> tuple[int, str]:
    printed = io.StringIO()
    with chdir(page["folder"]), redirect_stdout(printed), redirect_stderr(printed):
        try:
            exec(compile(code, "<page>", "exec"), page["names"])
        except Exception:
            traceback.print_exc()
            return 1, printed.getvalue()
    return 0, printed.getvalue()


def setup(app: object) -> dict:
    """Register the directive."""
    app.add_directive("run", Run)  # type: ignore[attr-defined]
    return {"parallel_read_safe": False}
