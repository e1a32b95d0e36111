"""What to measure where records cannot tell effects apart."""

from collections.abc import Sequence

from it2hys.model.chain import EFFECTS


def deciding_experiment(effects: Sequence[str]) -> str:
    """Return in a sentence which records would tell the effects apart."""
    wanted = list(dict.fromkeys(EFFECTS[e].EXPERIMENT for e in effects))
    return f"To tell {' from '.join(effects)}, record " + "; and ".join(wanted) + "."
