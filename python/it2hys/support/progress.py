"""The progress of long work: one kind of it, wherever it is shown."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Literal

#: Called with the share done, 0 to 1, and a text on the present step.
Progress = Callable[[float, str], None]
#: A bar where standard error is a terminal; a bar in any case, as notebooks show it; a line for every
#: step of the work, for logs.
Kind = Literal["terminal", "bar", "lines"]


def silent(share: float, text: str) -> None:
    """Show nothing."""


def part(progress: Progress, low: float, high: float) -> Progress:
    """Return the progress of a part of some work, from one share of the whole to another."""
    return lambda share, text: progress(low + (high - low) * share, text)


@contextmanager
def progress_bar(quiet: bool = False, kind: Kind = "terminal") -> Iterator[Progress]:
    """Hand out the progress of some work, shown on standard error.

    Parameters
    ----------
    quiet : bool
        Show nothing.
    kind : {"terminal", "bar", "lines"}
        What is shown otherwise. A pipe or a file gets nothing of the first.
    """
    if quiet or (kind == "terminal" and not sys.stderr.isatty()):
        yield silent
    elif kind == "lines":
        yield _lines()
    else:
        with _bar() as show:
            yield show


@contextmanager
def _bar() -> Iterator[Progress]:
    from tqdm import tqdm

    with tqdm(total=1.0, bar_format="{percentage:3.0f}%|{bar:30}| {elapsed} {desc}") as bar:

        def show(share: float, text: str) -> None:
            bar.desc, bar.n = text, max(bar.n, min(share, 1.0))
            bar.refresh()

        yield show
        show(1.0, "done")


def _lines() -> Progress:
    """Return a progress that writes a line for every text that is new."""
    begin, last = time.monotonic(), ""

    def show(share: float, text: str) -> None:
        nonlocal last
        if text != last:
            print(
                f"{time.monotonic() - begin:7.1f} s {share:4.0%}  {text}", file=sys.stderr, flush=True
            )
            last = text

    return show
