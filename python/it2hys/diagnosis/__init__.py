"""The loop that finds what a model lacks: residual, missing effect, better model.

`diagnose` is the whole; `criterion` fits a chain to records in free run, `fitting` adds effects to it,
`selection` searches for the set of effects that predicts best, `comparison` tells a gain from chance,
`residuals` says what is left.
"""

from it2hys.diagnosis.diagnose import RULES, diagnose
from it2hys.diagnosis.outcome import Diagnosis

__all__ = ["RULES", "Diagnosis", "diagnose"]
