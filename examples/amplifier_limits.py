"""A voltage under an amplifier's limits, by IPOPT over the chain in CasADi.

The reference asks for edges that the amplifier's slew rate does not allow. The closed-form inverse asks
at every tick for the voltage of that tick, and clamps: it begins an edge when the edge begins. The
optimum knows the whole reference, and begins before. Both voltages drive the compiled plant, amplifier
included. Run with ``python examples/amplifier_limits.py``.
"""

import casadi as ca
import numpy as np

from it2hys import casadi_chain
from it2hys.model import compiled
from it2hys.model.parameters import table_1

UM = 1e6
TICKS = 250
#: The stage: the paper's, with a lag of its amplifier and a creep term.
STAGE = table_1().replace(
    **{"initialDisplacement": 3e-6, "lag.timeConstant": 2e-4},
    **{"creepCount": 1, "creep[1].gain": 0.02, "creep[1].timeConstant": 0.02},
)
#: What the amplifier gives: 5 to 80 V, 15 V/ms.
LIMITS = {"saturation.minimum": 5.0, "saturation.maximum": 80.0, "slew.rate": 1.5e4}


def reference() -> np.ndarray:
    """Return a trapezoid from 3 to 10 µm with edges of 2 ms, m, shape (TICKS,)."""
    time = np.arange(TICKS) * STAGE["sampleTime"]
    return 1e-6 * np.interp(time, [0.0, 0.008, 0.010, 0.015, 0.017], [3.0, 3.0, 10.0, 10.0, 3.0])


def optimal_voltage(wanted: np.ndarray, guess: np.ndarray) -> np.ndarray:
    """Return the voltage within the limits whose displacement has the least squared error, V.

    The amplifier's limits are constraints here, so the chain needs none; what is left of it is smooth.
    """
    chain = casadi_chain(STAGE)
    begin = chain.rest()["state"]
    voltage = ca.MX.sym("voltage", 1, TICKS)
    run = chain.step.mapaccum(TICKS)(state=begin, voltage=voltage, temperature=293.15)
    error = UM * (run["displacement"] - wanted[None, :])
    first = voltage_at_rest()
    change = ca.diff(ca.horzcat(first, voltage), 1, 1)
    most = LIMITS["slew.rate"] * STAGE["sampleTime"]
    problem = {"x": voltage.T, "f": ca.sumsqr(error), "g": change.T}
    quiet = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes"}
    solver = ca.nlpsol("solver", "ipopt", problem, quiet)
    found = solver(
        x0=guess,
        lbx=LIMITS["saturation.minimum"],
        ubx=LIMITS["saturation.maximum"],
        lbg=-most,
        ubg=most,
    )
    return found["x"].full()[:, 0]


def voltage_at_rest() -> float:
    """Return the voltage that holds the stage where it begins, V."""
    return compiled.chain_equilibrium(STAGE)


def rms_error(voltage: np.ndarray, wanted: np.ndarray) -> float:
    """Return the error of the plant behind its amplifier, m rms."""
    displacement, _ = compiled.chain_free_run(STAGE.replace(**LIMITS), voltage)
    return float(np.sqrt(np.mean((displacement - wanted) ** 2)))


def main() -> dict[str, np.ndarray]:
    """Print the errors of both voltages, and return these."""
    wanted = reference()
    clamped, saturated = compiled.chain_inverse_run(STAGE.replace(**LIMITS), wanted)
    voltages = {
        "closed-form inverse": clamped,
        "IPOPT over the chain": optimal_voltage(wanted, clamped),
    }
    print(f"the inverse clamps at {np.count_nonzero(saturated)} of {TICKS} ticks")
    for name, voltage in voltages.items():
        print(f"{name:22} {UM * rms_error(voltage, wanted):.4f} µm rms")
    return voltages


if __name__ == "__main__":
    main()
