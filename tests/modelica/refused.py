"""Parameter sets that FMUs and pure Modelica refuse, and with which words."""

from it2hys.model.parameters import table_1

TWO_PLAYS = {
    "playCount": 2,
    "play[1].threshold": 8.0,
    "play[1].weight": 0.1,
    "play[2].threshold": 20.0,
    "play[2].weight": 0.1,
}
CREEP = {"creepCount": 1, "creep[1].gain": 0.1, "creep[1].timeConstant": 1.0}
NO_GAIN = {f"rule[{i}].q2": 0.0 for i in (1, 2, 3)}

#: What is changed in Table 1, and what a message says behind the block's name.
BAD: dict[str, tuple[dict, str]] = {
    "narrow upper membership": (
        {"rule[1].sigmaUpper": 1e-6},
        "ruleSigmaUpper[1] is 1e-06, below ruleSigmaLower[1], 4.3427e-06; the upper membership must be "
        "the wider one (are the two swapped?)",
    ),
    "no deviation": (
        {"rule[2].sigmaLower": 0.0},
        "ruleSigmaLower[2] is 0; it must be 1e-12 to 1",
    ),
    "no sample time": ({"sampleTime": 0.0}, "sampleTime is 0; it must be 1e-09 to 1000"),
    "negative lag": ({"lag.timeConstant": -1.0}, "lagTimeConstant is -1; it must be 0 to 1e+06"),
    "long lag": (
        {"sampleTime": 1.23457e-8, "lag.timeConstant": 20.5},
        "lagTimeConstant is 20.5 s; at a sampleTime of 1.23457e-08 s it must be at most 12.3457 s",
    ),
    "high resonance": (
        {"resonance.frequency": 6e3, "resonance.damping": 0.1},
        "resonanceFrequency is 6000 Hz; at a sampleTime of 0.0001 s it must be 0.1 Hz to below 5000 Hz "
        "(Nyquist), or 0 for none",
    ),
    "no damping": (
        {"resonance.frequency": 600.0},
        "resonanceDamping is 0; it must be above 0 and below 1",
    ),
    "not a number": ({"rule[2].q1": float("nan")}, "ruleQ1[2] is nan; it must be -10 to 10"),
    "no gain": (
        NO_GAIN,
        "the sum of ruleQ2 times the memberships is not positive at a displacement of 0: the model "
        "cannot be inverted there; raise q2 of the rules near it or narrow "
        "displacementMin..displacementMax",
    ),
    "no contraction": (
        {f"rule[{i}].q1": 1.2 for i in (1, 2, 3)},
        "the contraction |dy_k/dy_{k-1}| is 1.185 at a displacement of 6.5e-06, where it must be "
        "below 1: a free run diverges; lower ruleQ1 or narrow displacementMin..displacementMax",
    ),
    "no voltages": (
        {"voltageMin": 110.0},
        "voltageMin, 110 V, must be below voltageMax, 110 V",
    ),
    "no displacements": (
        {"displacementMin": 2e-5},
        "displacementMin, 2e-05, must be below displacementMax, 1.6e-05",
    ),
    "falling thresholds": (
        TWO_PLAYS | {"play[2].threshold": 2.0},
        "playThreshold[2] is 2 V; thresholds must rise, so it must be at least 8 V",
    ),
    "negative weights": (
        TWO_PLAYS | {"play[2].weight": -1.2},
        "1 plus the weights up to playWeight[2] is -0.1; it must be positive: the play operators would "
        "not be monotone and could not be inverted",
    ),
    "a weight too few": (
        TWO_PLAYS | {"playCount": 3, "play[3].threshold": 30.0},
        "playWeight has 2 elements and playThreshold has 3; they must have the same number",
    ),
    "a time constant too many": (
        CREEP | {"creep[2].timeConstant": 5.0},
        "creepTimeConstant has 2 elements and creepGain has 1; they must have the same number",
    ),
    "a constant of a rule too many": (
        {"rule[4].q3": 1e-6},
        "ruleQ3 has 4 elements and ruleSigmaLower has 3; they must have the same number",
    ),
    "no time constant": (
        CREEP | {"creep[1].timeConstant": 0.0},
        "creepTimeConstant[1] is 0 s; it must be positive",
    ),
    "negative creep": (
        CREEP | {"creep[1].gain": -1.5},
        "1 plus the negative gains up to creepGain[1] is -0.5; it must be positive: creep could not be "
        "inverted",
    ),
    "long delay": (
        {"delay.time": 7e-3},
        "delayTime is 0.007 s; at a sampleTime of 0.0001 s it must be at most 0.0064 s, 64 ticks",
    ),
    "exchanged limits": (
        {"saturation.minimum": 5.0},
        "saturationMinimum, 5 V, must be below saturationMaximum, 0 V (both 0: no saturation)",
    ),
    "falling curve": (
        {"nonlinearity.cubic": 1e-5},
        "nonlinearityQuadratic to nonlinearitySextic make a curve that falls 0 m above "
        "displacementZero; it must rise from nonlinearityMinimum to nonlinearityMaximum",
    ),
    "empty curve": (
        {"nonlinearity.cubic": 1e-7, "nonlinearity.minimum": 2e-5},
        "nonlinearityMinimum, 2e-05 m, must be below nonlinearityMaximum, 1.6e-05 m",
    ),
    "hum without frequency": (
        {"hum.amplitude": 1e-8},
        "humFrequency is 0 Hz; with a humAmplitude it must be positive",
    ),
    "far start": (
        {"initialDisplacement": 1e-3},
        "initialDisplacement is 0.001 m: the run would begin more than 4 times the length of "
        "displacementMin..displacementMax, 0 to 1.6e-05 m, outside it; set it to where the stage is "
        "(is it in another unit?)",
    ),
}


class Unchecked(dict):
    """The values of a set by name, usable or not."""

    name = "refused"


def parameters_of(changes: dict) -> Unchecked:
    """Return Table 1 with changes, which nobody has checked."""
    return Unchecked({**table_1(), **changes})
