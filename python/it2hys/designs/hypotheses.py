"""The rival models that a record is to decide between, each with its own parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.rest import resting
from it2hys.diagnosis.variants import behind_gain, with_effect, without_effect
from it2hys.errors import InputError
from it2hys.identification.criterion import Model, Trace
from it2hys.identification.effect_coordinates import by_record, of_reading
from it2hys.identification.inverse import References
from it2hys.identification.starts import SHIFT, SHIFTING
from it2hys.model.chain import active_effects
from it2hys.model.compiled import Drive, chain_check, chain_predict
from it2hys.model.parameters import ParameterSet, read_ssv
from it2hys.model.stages import EFFECTS
from it2hys.model.variables import load_table
from it2hys.policy import DESIGN
from it2hys.records.clues import Clue, Clues, Extent
from it2hys.stand.excitations import identification
from it2hys.support.files import read_json
from it2hys.support.keys import known_names

#: Name of the model without the effects in which the rivals differ.
NEITHER = "neither"
#: Noise where nothing is known of the sensor, as a share of the travel.
_USUAL_NOISE = 5e-4
#: Samples of the voltage on which the size of an effect is measured.
_PROBE = 4000
#: Sizes that are as likely are as large up to this factor; correlation from which on two effects act
#: in the same way.
_AS_LIKELY, _ALIKE = 3.0, 0.9
#: Factors by which guesses are made weaker or stronger.
_SCALES = (0.25, 0.5, 2.0)
#: Shares of the bound that are guessed of what a fit begins with at none.
_SHARES = 0.1 * np.geomspace(0.01, 1.0, 7)
#: Other sizes for which a promise is made, by the usual one; log of the ratio by which
#: one may differ from that.
_OTHER_SIZES, _NEAR = (0.5, 2.0), float(np.log(1.4))


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A model that may be the right one.

    Parameters
    ----------
    name : str
        The effects that it has and the others lack.
    effects : tuple of str
        All that it has, in the order in which they came.
    parameters : ParameterSet
    said : str
        Where its parameters are from.
    own : tuple of str
        Effects of the name; none of the model without them.
    variants : tuple of Hypothesis
        The same with other parameters that are as likely and act otherwise.
    sizes : tuple of Hypothesis
        The same of about half the size, and of twice, where they are as likely.
    """

    name: str
    effects: tuple[str, ...]
    parameters: ParameterSet
    said: str = ""
    own: tuple[str, ...] = ()
    variants: tuple[Hypothesis, ...] = ()
    sizes: tuple[Hypothesis, ...] = ()

    @cached_property
    def model(self) -> Model:
        """The chain of one record."""
        known = load_table().parameters()
        names = [n for n in by_record() if known[n].effect in (None, *self.effects)]
        return Model(
            dict(self.parameters),
            self.effects,
            np.zeros(1),
            {n: np.array([float(self.parameters[n])]) for n in names},
        )

    def at_rest(self, voltage: float) -> Hypothesis:
        """Return the model at long rest at a voltage, V."""
        clear = {n: 0.0 for n in by_record() if n not in of_reading() and n != "initialDisplacement"}
        rested = resting(self.parameters.replace(**clear), voltage)
        variants, sizes = (
            tuple(other.at_rest(voltage) for other in others) for others in (self.variants, self.sizes)
        )
        return replace(self, parameters=rested, variants=variants, sizes=sizes)


@dataclass(frozen=True, eq=False)
class Question:
    """The question that a designed record is to answer.

    Parameters
    ----------
    hypotheses : tuple of Hypothesis
        Those between which it is to decide; one alone whose parameters are to be determined.
    neither : Hypothesis or None
        The model without what these differ in.
    noise : float
        Of the displacement, m rms.
    duration, rate : float or None
        Of the records at hand: the longest, s, and the fastest change of the voltage, V/s.
    said : tuple of str
        Sentences on the source of values that were not given.
    """

    hypotheses: tuple[Hypothesis, ...]
    neither: Hypothesis | None
    noise: float
    duration: float | None = None
    rate: float | None = None
    said: tuple[str, ...] = ()

    @property
    def base(self) -> ParameterSet:
        """The parameters of the model without what the rivals differ in, or of the only one."""
        return (self.neither or self.hypotheses[0]).parameters


def trace_of(voltage: np.ndarray, y: np.ndarray, noise: float, sample_time: float) -> Trace:
    """Return a record, all of whose samples are fitted and judged, from voltage, V, and reading, m."""
    trusted = np.ones(len(y), dtype=bool)
    references = References(y, trusted, noise, sample_time)
    return Trace(
        "designed", "train", Drive.of(voltage), y, 1.0 * trusted, trusted, 0, noise, references
    )  # fmt: skip


def effects_of(parameters: ParameterSet) -> tuple[str, ...]:
    """Return the effects of a set, without the part of a sample that only goes with a sampled one."""
    here = active_effects(parameters)
    others = [e for e in here if e != SHIFTING]
    is_part = parameters[SHIFT] <= parameters["sampleTime"] and any(EFFECTS[e].sampled for e in others)
    return tuple(others if is_part else here)


# --- from a model and names of effects ---------------------------------------------------------------


def between(parameters: ParameterSet, effects: Sequence[str], noise: float | None = None) -> Question:
    """Return the question which of some effects a model has.

    Those that the parameter set has stay as they are there; the others are given the size that changes
    the displacement by a usual share of the travel.

    Parameters
    ----------
    parameters : ParameterSet
    effects : sequence of str
        At least two names.
    noise : float, optional
        Of the sensor, m rms.

    Raises
    ------
    InputError
        If a name is no effect's or twice there, or the voltage cannot show the effect.
    """
    for name in effects:
        if name not in EFFECTS:
            raise InputError(f"--between: no effect {name!r}; {known_names(name, list(EFFECTS))}")
    if len({*effects}) < max(2, len(effects)):
        raise InputError(f"--between {','.join(effects)}: name at least two effects, each once")
    here = effects_of(parameters)
    whole = Hypothesis(NEITHER, here, parameters)
    model = whole.model
    for effect in (e for e in effects if e in here):
        model = without_effect(model, effect)
    neither = _hypothesis(NEITHER, model, "the model without any of them", ())
    hypotheses = []
    for effect in effects:
        if effect in here:
            own = whole.model
            for other in (e for e in effects if e in here and e != effect):
                own = without_effect(own, other)
            said = f"{effect}: as in the parameter set"
            hypotheses.append(_hypothesis(effect, own, said, (effect,)))
        else:
            hypotheses.append(_typical(neither, effect))
    told = [h.said for h in hypotheses]
    if noise is None:
        noise, text = _usual_noise(parameters)
        told.append(text)
    return Question(tuple(hypotheses), neither, noise, said=tuple(told))


def _hypothesis(name: str, model: Model, said: str, own: tuple[str, ...]) -> Hypothesis:
    return Hypothesis(name, tuple(model.effects), _set_of(model, name).validate(), said, own)


def _set_of(model: Model, name: str) -> ParameterSet:
    values = dict(model.values)
    for effect in EFFECTS.values():
        values = effect.ordered(values)
    return ParameterSet(values, name)


def _typical(neither: Hypothesis, effect: str) -> Hypothesis:
    """Return the model with an effect of a usual size, and with others that are as likely.

    Of the guesses that a fit would begin with it is the one whose change of the displacement is nearest
    to a usual share of the travel. Others change it alike, by about half of that or twice. The change
    of one more is about as large, and the least like it: a voltage is limited at its other end, or
    something slow is slower.
    """
    evidence = EVIDENCE[effect]
    if evidence.channel == "force":
        raise InputError(
            f"--between {effect}: it shows only in records with a {evidence.channel} column; no "
            "voltage decides it"
        )
    wanted, guessed = _guessed(neither, effect)
    if not guessed:
        raise InputError(
            f"--between {effect}: no usual size of this effect is known; give a parameter set that has "
            "it"
        )
    usual = min(guessed, key=lambda g: g.beyond(wanted))
    said = (
        f"{effect}: {_listed(usual.values)}, a usual size, which changes the displacement by "
        f"{1e6 * usual.size:.3g} µm rms"
    )
    alike = [g for g in guessed if g.is_like(usual) >= _ALIKE]
    seen = [g for g in alike if not evidence.is_within_a_sample(g.model.values)]
    sizes = [g for factor in _OTHER_SIZES for g in _nearest(seen, factor * usual.size)]
    if sizes:
        said += f"; it has to be told at {' and '.join(f'{1e6 * g.size:.3g} µm' for g in sizes)}, too"
    as_likely = [g for g in guessed if g.beyond(wanted) < np.log(_AS_LIKELY)]
    other = min([usual, *as_likely], key=lambda g: g.is_like(usual))
    kinds = [] if other.is_like(usual) >= _ALIKE else [other]
    if kinds:
        said += f"; {_listed(other.values)} is as likely, and has to be told, too"
    found = _hypothesis(effect, usual.model, said, (effect,))
    return replace(
        found,
        variants=tuple(_hypothesis(f"{effect} otherwise", g.model, said, (effect,)) for g in kinds),
        sizes=tuple(
            _hypothesis(f"{effect} of {1e6 * g.size:.3g} µm", g.model, said, (effect,)) for g in sizes
        ),
    )


@dataclass(frozen=True, eq=False)
class _Guess:
    """A model with an effect, the values it was given, and by what it changes the displacement.

    Parameters
    ----------
    model : Model
    values : Mapping
    size : float
        Root of the mean square of the change, m.
    change : ndarray, shape (N,)
        In units of that.
    """

    model: Model
    values: Mapping[str, float]
    size: float
    change: np.ndarray

    def is_like(self, other: _Guess) -> float:
        """Return how alike two changes are, from 0 to 1: their correlation, whatever the sign."""
        return abs(float(np.mean(self.change * other.change)))

    def beyond(self, wanted: float) -> float:
        """Return the log of the ratio to a wanted size, m, whichever is larger."""
        return abs(float(np.log(self.size / wanted)))


def _guessed(neither: Hypothesis, effect: str) -> tuple[float, list[_Guess]]:
    """Return a usual size, m, and models with what a fit of an effect begins with."""
    model, evidence = neither.model, EVIDENCE[effect]
    low, high = neither.parameters.voltage_range
    sample_time = neither.parameters["sampleTime"]
    shape = identification(np.arange(_PROBE) * 1e-4)
    voltage = low + (high - low) * shape / shape.max()
    drive = Drive.of(voltage)
    run = chain_predict(model.packed(0), drive)[0]
    extent = Extent(
        sample_time,
        _PROBE * sample_time,
        (low, high),
        (float(run.min()), float(run.max())),
        zero=neither.parameters["displacementZero"],
    )
    clue = Clue(voltage, drive.force, drive.temperature, run, np.zeros(_PROBE), np.ones(_PROBE, bool))
    trace, found = trace_of(voltage, run, 0.0, sample_time), []
    guesses = evidence.guesses(Clues(extent, [clue]))
    guesses = [*guesses, *_scaled(effect, guesses, extent), *_from_bounds(effect, extent)]
    for values in guesses:
        trial = with_effect(model, effect, values, extent)
        if gain := evidence.gain_at_rest(trial.values):
            moved = behind_gain(trial, gain, [trace])
            # a core moved beyond what can be inverted is none of a stage
            trial = trial if chain_check(_set_of(moved, effect)) else moved
        with np.errstate(over="ignore", invalid="ignore"):  # of a run on its way to infinity
            change = trial.predict(trace, 0) - run
            size = float(np.sqrt(np.mean(change**2)))
        if size > 0.0 and np.isfinite(size):
            found.append(_Guess(trial, values, size, change / size))
    return DESIGN.typical * float(np.ptp(run)), found


def _nearest(guesses: Sequence[_Guess], wanted: float) -> list[_Guess]:
    """Return the guess whose size is nearest to a wanted one, m; none where it is not near."""
    near = [g for g in guesses if g.beyond(wanted) < _NEAR]
    return sorted(near, key=lambda g: g.beyond(wanted))[:1]


def _scaled(
    effect: str, guesses: Sequence[Mapping[str, float]], extent: Extent
) -> list[dict[str, float]]:
    """Return guesses with other strengths: of what makes no effect at 0, which is its least value."""
    starts = EFFECTS[effect].starts(extent)
    most = {n: s.high for n, s in starts.items() if s.low == 0.0 < s.value and not s.of_sampling}
    return [
        {**guess, **scaled}
        for guess in guesses
        for factor in _SCALES
        if (scaled := {n: factor * guess[n] for n in most if n in guess})
        and all(value <= most[n] for n, value in scaled.items())
    ]


def _from_bounds(effect: str, extent: Extent) -> list[dict[str, float]]:
    """Return values a little of the way to their bound, of what a fit begins with at none."""
    starts = EFFECTS[effect].starts(extent)
    names = [n for n, s in starts.items() if s.value == 0.0 and n not in by_record()]
    return [{n: share * starts[n].high for n in names} for share in _SHARES] if names else []


def _listed(values: Mapping[str, float]) -> str:
    """Return the first parameters of a guess, with their units."""
    known = load_table().parameters()
    shown = [
        f"{n} = {v:.3g}" + ("" if known[n].type.unit == "1" else f" {known[n].type.unit}")
        for n, v in values.items()
        if v and known[n].group is None and known[n].type.base == "Real"
    ] or [f"{n} = {v:.3g}" for n, v in list(values.items())[:4]]
    return ", ".join(shown[:3])


# --- from a report -------------------------------------------------------------------------------


def question_of(
    source: str | Path, effects: Sequence[str] = (), noise: float | None = None
) -> Question:
    """Return the question of a report, or of a parameter set and effects.

    Parameters
    ----------
    source : path
        A `report.json`, or a parameter set (.ssv).
    effects : sequence of str
        Those between which to decide; of a report by default those that its records cannot tell apart.
    noise : float, optional
        In m rms; that of the report by default.

    Raises
    ------
    InputError
        If the file cannot be used, or asks for nothing that a record could decide.
    """
    source = Path(source)
    if source.suffix == ".ssv":
        parameters = read_ssv(source)
        try:
            return question_of_set(parameters, effects, noise)
        except InputError as error:
            raise InputError(f"{source}: {error}") from None
    _check_noise(noise)
    report = read_json(
        source,
        ("noise_rms_um", "records", "indistinguishable", "parameters", "effects"),
        "",
        "; give the report.json that `it2hys diagnose` wrote, or a .ssv",
    )
    try:
        return question_of_report(report, lambda: _beside(source), effects, noise)
    except InputError as error:
        raise InputError(f"{source}: {error}") from None


def question_of_set(
    parameters: ParameterSet, effects: Sequence[str] = (), noise: float | None = None
) -> Question:
    """Return the question which of some effects a model has, or, of none, how large its own ones are.

    Parameters and errors are as in `question_of`.
    """
    _check_noise(noise)
    if effects:
        return between(parameters, effects, noise)
    own = effects_of(parameters)
    if not own:
        raise InputError(
            "the set has no effect whose parameters could be determined; name rivals with "
            "--between EFFECT,EFFECT"
        )
    told: tuple[str, ...] = ()
    if noise is None:
        noise, text = _usual_noise(parameters)
        told = (text,)
    return Question((Hypothesis("the model", own, parameters),), None, noise, said=told)


def _check_noise(noise: float | None) -> None:
    if noise is not None and not (np.isfinite(noise) and noise > 0.0):
        raise InputError(f"--noise {1e6 * noise:g}: must be positive")


def _usual_noise(parameters: ParameterSet) -> tuple[float, str]:
    """Return the noise of a usual sensor, m rms, and that it is one."""
    low, high = parameters.displacement_range
    noise = _USUAL_NOISE * (high - low)
    return (
        noise,
        f"noise: {1e6 * noise:.3g} µm, a usual share of the travel; --noise gives your sensor's",
    )


def question_of_report(
    report: Mapping,
    found: Callable[[], ParameterSet],
    effects: Sequence[str] = (),
    noise: float | None = None,
) -> Question:
    """Return the question that a report leaves open.

    Parameters
    ----------
    report : Mapping
        What `report.json` holds.
    found : callable
        Returns the parameter set that it is of.
    effects, noise
        As in `question_of`.

    Raises
    ------
    InputError
        If there is nothing that a record could decide.
    """
    known = noise if noise is not None else 1e-6 * float(report["noise_rms_um"])
    about = {
        "duration": max(r["samples"] * r["sample_time_s"] for r in report["records"].values()),
        "rate": max(r.get("fastest_V_per_s", 0.0) for r in report["records"].values()) or None,
    }
    rivals = report.get("rivals") or []
    group = [*effects] or [*(report["indistinguishable"] or [[]])[0]]
    if not effects and len(rivals) > 2:
        neither, *others = (_of_report(r) for r in rivals)
        return Question(tuple(others), neither, known, **about)
    if group:
        return replace(between(found(), group, known), **about)
    undetermined = [n for n, p in report["parameters"].items() if not p["determined"]]
    if not report["effects"] and not undetermined:
        raise InputError(
            "the report leaves nothing to decide: its records tell all effects apart and determine all "
            "parameters; name effects to decide between with --between EFFECT,EFFECT"
        )
    parameters = found()
    only = Hypothesis("the model", effects_of(parameters), parameters)
    return Question((only,), None, known, **about)


def _of_report(entry: Mapping) -> Hypothesis:
    own = tuple(entry["own"])
    parameters = ParameterSet(entry["parameters"], " + ".join(own) or NEITHER).validate()
    said = f"{' + '.join(own)}: as fitted to the records" if own else "the model without any of them"
    return Hypothesis(" + ".join(own) or NEITHER, tuple(entry["effects"]), parameters, said, own)


def _beside(source: Path) -> ParameterSet:
    """Return the parameter set that lies beside a report."""
    return read_ssv(source.with_name("parameters.ssv"))
