"""Time of a tick of the blocks in pure Modelica, in rumoca, beside a sample event with nothing in it.

    PYTHONPATH=tests python tests/modelica/speed.py [TICKS]

The models run in turns, in processor time; quoted are medians. rumoca interprets what other tools
compile, and makes no code of sampled models: its figures compare two versions of a block and say
nothing of another tool. `omc_acceptance.py --only speed` measures OpenModelica, where the aim is 3 us.
"""

import statistics
import sys
import time

from library import INVERSE, PLANT, model
from test_simulation import compile_model, rumoca

TICKS, ROUNDS, SAMPLE_TIME = 20_000, 5, 1e-4
VOLTAGE, REFERENCE = "50 + 45*sin(126*time)", "8e-6 + 6e-6*sin(126*time)"
EFFECTS = (
    "playThreshold={2,8}, playWeight={0.04,0.06}, creepGain={0.02,0.01}, creepTimeConstant={5e-3,0.5}, "
    "delayTime=1.5e-4, lagTimeConstant=2e-4, resonanceFrequency=1000, resonanceDamping=0.1"
)
MODELS = {
    "nothing": model(
        "discrete Real y(start=0, fixed=true);", f"when sample(0, 1e-4) then y = {VOLTAGE}; end when;"
    ),
    "plant": model(f"{PLANT} plant;", f"plant.voltage = {VOLTAGE};"),
    "plant, effects": model(f"{PLANT} plant(parameters({EFFECTS}));", f"plant.voltage = {VOLTAGE};"),
    "inverse": model(f"{INVERSE} inverse;", f"inverse.reference = {REFERENCE};"),
    "inverse, effects": model(
        f"{INVERSE} inverse(parameters({EFFECTS}));", f"inverse.reference = {REFERENCE};"
    ),
}


def seconds(compiled: "rumoca.Model", ticks: int) -> float:
    """Return the processor time of a run that stores next to nothing."""
    stop = (ticks - 1) * SAMPLE_TIME
    start = time.process_time()
    compiled.simulate(t=(0.0, stop), dt=stop / 4, config=rumoca.SimConfig(solver="rk-like"))
    return time.process_time() - start


if __name__ == "__main__":
    ticks = int(sys.argv[1]) if sys.argv[1:] else TICKS
    compiled = {name: compile_model(source) for name, source in MODELS.items()}
    turns = [{name: seconds(m, ticks) for name, m in compiled.items()} for _ in range(ROUNDS)]
    for name in MODELS:
        print(
            f"{name:18}{statistics.median(turn[name] for turn in turns) / ticks * 1e6:8.1f} us a tick"
        )
