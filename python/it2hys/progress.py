"""The progress bar of long work."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm


@contextmanager
def progress_bar(quiet: bool = False) -> Iterator[Callable[[float, str], None]]:
    """Show a bar; the function handed out takes the share done, 0 to 1, and what is being done."""
    with tqdm(
        total=1.0, disable=quiet, bar_format="{percentage:3.0f}%|{bar:30}| {elapsed} {desc}"
    ) as bar:

        def show(share: float, text: str) -> None:
            bar.desc = text
            bar.update(max(0.0, min(share, 1.0) - bar.n))

        yield show
        show(1.0, "done")
