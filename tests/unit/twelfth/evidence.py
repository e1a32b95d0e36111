"""The twelfth effect shows in a residual that follows the displacement's change."""

from it2hys.diagnosis.evidence.base import EffectEvidence, Signature
from it2hys.diagnosis.evidence.statistics import Ground, modelled, moved, readable
from it2hys.records.clues import Clues


class TiltEvidence(EffectEvidence):
    """A residual that follows the displacement's change from tick to tick."""

    meaning = "the displacement is ahead of itself"
    experiment = "triangles of several frequencies"

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return gains of both signs."""
        return [{"tilt.gain": gain} for gain in (-0.2, 0.1, 0.5, 1.0)]

    def signature(self, clues: Clues) -> Signature | None:
        """Return whether the residual follows the change."""
        seen = readable(clues)
        if seen is None:
            return None
        trial = Ground(seen, []).test(lambda c: moved(modelled(c)))
        text = (
            f"The residual follows the displacement's change: {100 * trial.share:.0f} % of its power."
        )
        return Signature(trial.share, trial.p_value, text)


EVIDENCE = TiltEvidence()
