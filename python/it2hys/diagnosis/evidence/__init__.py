"""The evidence on the effects: a module each, which says what in a record speaks for it.

`base` has what they share, `statistics` the tests of a residual that hold for coloured ones too.
"""

from importlib import import_module

from it2hys.diagnosis.evidence.base import EffectEvidence, Signature
from it2hys.model.stages import STAGES

#: By the effect's name, in the order of the chain.
EVIDENCE: dict[str, EffectEvidence] = {
    name: import_module(f"{__name__}.{name}").EVIDENCE for name in STAGES
}

__all__ = ["EVIDENCE", "EffectEvidence", "Signature"]
