"""The progress bar of long work."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm

#: Is told the share done, 0 to 1, and what is being done.
Progress = Callable[[float, str], None]


def part(progress: Progress, low: float, high: float) -> Progress:
    """Return the progress of a part of some work, from one share of the whole to another."""
    return lambda share, text: progress(low + (high - low) * share, text)


@contextmanager
def progress_bar(quiet: bool = False) -> Iterator[Progress]:
    """Show a bar; the function handed out takes the share done, 0 to 1, and what is being done."""
    with tqdm(
        total=1.0, disable=quiet, bar_format="{percentage:3.0f}%|{bar:30}| {elapsed} {desc}"
    ) as bar:

        def show(share: float, text: str) -> None:
            bar.desc, bar.n = text, max(bar.n, min(share, 1.0))
            bar.refresh()

        yield show
        show(1.0, "done")
