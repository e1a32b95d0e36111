"""The experiment to make where records cannot tell effects apart."""

from collections.abc import Sequence

from it2hys.diagnosis.evidence import EVIDENCE


def deciding_experiment(effects: Sequence[str]) -> str:
    """Return in a sentence which records would tell the effects apart."""
    wanted = list(dict.fromkeys(EVIDENCE[e].experiment for e in effects))
    return f"To tell {' from '.join(effects)}, record " + "; and ".join(wanted) + "."
