"""The evidence on the effects: a module each, which says what in a record speaks for it.

`base` has what they share, `statistics` the tests of a residual that hold for coloured ones too, `own`
what follows for an effect of the user's own from its declaration.
"""

from collections.abc import Iterator, Mapping
from importlib import import_module

from it2hys.diagnosis.evidence.base import EffectEvidence, Signature
from it2hys.diagnosis.evidence.own import own_evidence
from it2hys.model.own_effect import OwnEffect
from it2hys.model.stages import EFFECTS

_BUILT_IN: dict[str, EffectEvidence] = {
    name: import_module(f"{__name__}.{name}").EVIDENCE
    for name, effect in EFFECTS.items()
    if not isinstance(effect, OwnEffect)
}


class _ByName(Mapping[str, EffectEvidence]):
    """The evidence on each effect of the chain, in its order: those of the user's own come and go."""

    def __getitem__(self, name: str) -> EffectEvidence:
        effect = EFFECTS[name]
        return own_evidence(effect) if isinstance(effect, OwnEffect) else _BUILT_IN[name]

    def __iter__(self) -> Iterator[str]:
        return iter(EFFECTS)

    def __len__(self) -> int:
        return len(EFFECTS)


EVIDENCE = _ByName()

__all__ = ["EVIDENCE", "EffectEvidence", "Signature"]
