"""The chain of a parameter set as CasADi functions, to state problems of optimal control on."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca

from it2hys.model.chain import Chain
from it2hys.model.compiled import REST_TEMPERATURE
from it2hys.model.parameters import ParameterSet


class CasadiChain(NamedTuple):
    """Plant and inverse of a parameter set; all in SI units, states are columns.

    Inputs that are not named in a call have defaults: no force, the reference temperature, the time 0
    and the set's `initialDisplacement`.

    Attributes
    ----------
    step : casadi.Function
        (state, voltage, force, temperature, time) -> (next_state, displacement, measured).
    rest : casadi.Function
        (displacement) -> (state, inverse_state), at rest there, before the first tick.
    inverse : casadi.Function
        (state, reference, force, temperature, time) -> (next_state, voltage, saturated), with a state
        of its own; `saturated` is 1 while the plant does not follow.
    """

    step: ca.Function
    rest: ca.Function
    inverse: ca.Function


def casadi_chain(parameters: ParameterSet) -> CasadiChain:
    """Return the chain of a parameter set, and its inverse, as CasADi functions of one tick.

    They compute what the FMUs compute, and CasADi derives every derivative of them. `step.mapaccum(N)`
    is a run of N ticks; CasADi does not hand defaults on to it, so it needs the temperature, too.
    `it2hys.model.chain.Chain` has the parameters as an argument.

    Parameters
    ----------
    parameters : ParameterSet
        The set, with the effects that it has.

    Returns
    -------
    CasadiChain

    Examples
    --------
    >>> from it2hys.model.parameters import table_1
    >>> chain = casadi_chain(table_1())
    >>> state = chain.rest(displacement=0.0)["state"]
    >>> float(chain.step(state=state, voltage=40.0)["displacement"]) > 0.0
    True
    """
    chain = Chain(parameters)
    p = chain.vector()
    around = [ca.SX.sym(name) for name in ("force", "temperature", "time")]
    defaults = [0.0, REST_TEMPERATURE, 0.0]
    state, inverse_state = (
        ca.SX.sym("state", chain.state_size),
        ca.SX.sym("state", chain.inverse_state_size),
    )
    voltage, reference = ca.SX.sym("voltage"), ca.SX.sym("reference")
    displacement = ca.SX.sym("displacement")
    begun = ca.SX(p)
    begun[chain.names.index("initialDisplacement")] = displacement
    return CasadiChain(
        step=ca.Function(
            "step",
            [state, voltage, *around],
            chain.step(p, state, voltage, *around),
            ["state", "voltage", "force", "temperature", "time"],
            ["next_state", "displacement", "measured"],
            {"default_in": [0.0, 0.0, *defaults]},
        ),
        rest=ca.Function(
            "rest",
            [displacement],
            [chain.rest(begun), chain.inverse_rest(begun)],
            ["displacement"],
            ["state", "inverse_state"],
            {"default_in": [parameters["initialDisplacement"]]},
        ),
        inverse=ca.Function(
            "inverse",
            [inverse_state, reference, *around],
            chain.inverse(p, inverse_state, reference, *around),
            ["state", "reference", "force", "temperature", "time"],
            ["next_state", "voltage", "saturated"],
            {"default_in": [0.0, 0.0, *defaults]},
        ),
    )
