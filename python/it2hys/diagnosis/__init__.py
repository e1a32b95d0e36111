"""The loop that finds what a model lacks: residual, missing effect, better model.

`diagnose` is the whole; `fitting` adds effects to a model and fits it, `selection` searches for the
set of effects that predicts best, by models that `refinement` makes; `evidence` holds what each effect
leaves in a residual, `comparison` and `chances` tell a gain from chance, `whole` leads from the
searched part of long records to all of them, `residuals` says what is left.
"""

from it2hys.diagnosis.diagnose import RULES, diagnose
from it2hys.diagnosis.outcome import RIVAL_FILES, Diagnosis

__all__ = ["RIVAL_FILES", "RULES", "Diagnosis", "diagnose"]
