"""Static curve, the stack's or the sensor's: the last stage before the displacement.

Its signature is a residual that is a function of the displacement alone: the same in rising and falling
branches, at every frequency and in every record. Data cannot tell a sensor's curve from an actuator's.
"""

import numpy as np

from it2hys.diagnosis.evidence.base import EffectEvidence, Signature
from it2hys.diagnosis.evidence.statistics import UM, Ground, branches, modelled, readable, scaled
from it2hys.model.effects.nonlinearity import COEFFICIENTS
from it2hys.records.clues import Clues


class NonlinearityEvidence(EffectEvidence):
    """A residual that is a function of the displacement alone."""

    meaning = "a bent static curve of the stage or its sensor"
    experiment = (
        "slow full-range loops beside small ones at several bias voltages (a static curve is the "
        "same in all)"
    )

    imitated = of_the_core = True

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return a curve that is hardly bent, and ones with one, two and three waves.

        The curve is over the model's readings, and stays there: other ends are another curve. Wider
        ones would ask a curve to rise where nothing was read, and keep it from its shape.
        """
        span = clues.extent.displacement_span
        # Chebyshev polynomials of degree 2, 3 and 4, less what is linear: 1 or 2 % of the travel high
        waves = np.diag([0.02, 0.04, 0.08, 0.0, 0.0])[:3]
        heights = (2.0, 1.0, -1.0, -2.0)
        shapes = [np.full(len(COEFFICIENTS), 1e-4), *(h * wave for wave in waves for h in heights)]
        strokes = np.concatenate([modelled(c)[c.used] for c in clues.records]) - clues.extent.zero
        if np.ptp(strokes) == 0.0:  # of a model that stands still there is no curve
            return []
        ends = {
            "nonlinearity.minimum": float(strokes.min()),
            "nonlinearity.maximum": float(strokes.max()),
        }
        names = [f"nonlinearity.{name}" for name in COEFFICIENTS]
        return [{**dict(zip(names, (span * s).tolist(), strict=True)), **ends} for s in shapes]

    def signature(self, clues: Clues) -> Signature | None:
        """Return whether the residual is a function of the displacement, the same on both branches.

        The residual is regressed on Chebyshev polynomials 2 to 8 of the model's reading, in all records
        by the same coefficients; errors are spectral and by blocks (HAC) and enlarged where records
        disagree. The statistic is the share of the residual's power that they explain. The text
        compares both branches. What the core bends to by itself is not in the residual any more.
        """
        seen = readable(clues)
        if seen is None or clues.extent.displacement_span <= 0.0:
            return None
        trial = Ground(seen, [modelled]).test(
            lambda c: np.polynomial.chebyshev.chebvander(np.clip(scaled(clues, c), -1.2, 1.2), 8)[:, 2:]
        )
        share = 100 * trial.share
        text = f"A function of the displacement alone explains {share:.0f} % of the residual's power"
        if (means := branches(seen)) is not None:
            rising, falling = means
            text += (
                f"; on average the residual is up to {np.max(np.abs(rising)) * UM:.2g} µm on "
                "rising and "
                f"{np.max(np.abs(falling)) * UM:.2g} µm on falling branches, with a correlation of "
                f"{np.corrcoef(rising, falling)[0, 1]:.2f} between them"
            )
        return Signature(trial.share, trial.p_value, text + ".")


EVIDENCE = NonlinearityEvidence()
