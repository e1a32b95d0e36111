"""The test package: a model for every example that compares itself with its stored result.

    PYTHONPATH=tests python tests/modelica/compared.py

writes modelica/IT2HysteresisTest/package.mo from the stored results; run it behind `reference.py`. A
Modelica tool that has loaded the library and this package simulates its models: one that is away from
what is stored stops, and says which signal it is. Every fourth of the stored times is compared.
"""

from library import EXAMPLES, LEAST, LIBRARY, ROUNDING, experiment, stored_result

from it2hys.export.modelica import LIBRARY_VERSION
from it2hys.support.files import write_atomically

PACKAGE = LIBRARY.parent / "IT2HysteresisTest" / "package.mo"
EVERY, SHARE = 4, 0.02

HEAD = """package IT2HysteresisTest "The examples of IT2Hysteresis, beside their stored results"
  extends Modelica.Icons.ExamplesPackage;

  function apart "Distance to a stored value: just before its time or just after, whichever is less"
    extends Modelica.Icons.Function;
    input Real stored[:] "Stored values";
    input Integer k "Which of them";
    input Real before "Value just before";
    input Real after "Value just after";
    output Real distance "Distance";
  algorithm
    distance := min(abs(before - stored[k]), abs(after - stored[k]));
  end apart;

  block Compared "Stops where a signal is away from its stored values more than once"
    parameter Real interval(unit="s") "Time between stored values";
    parameter Real moment(unit="s") "How long before and behind it the signal is read";
    parameter Real stored[:] "Values, the first at the end of the first interval";
    parameter Real tolerance "Distance that is none";
    Modelica.Blocks.Interfaces.RealInput u "Signal";
    discrete Integer k(start=0, fixed=true) "Values compared";
    discrete Integer misses(start=0, fixed=true) "Times that the signal was away";
    discrete Real before(start=0, fixed=true) "Signal just before";
  equation
    when sample(interval - moment, interval) then
      before = u;
    end when;
    when sample(interval + moment, interval) then
      k = min(pre(k) + 1, size(stored, 1));
      misses = pre(misses)
        + (if apart(stored, min(pre(k) + 1, size(stored, 1)), before, u) > tolerance then 1 else 0);
      assert(pre(misses) < 2, getInstanceName() + ": the signal is away from its stored values.");
    end when;
  end Compared;
"""


def model_of(name: str) -> str:
    """Return the model that compares an example."""
    short, (stop, interval) = name.rsplit(".", 1)[-1], experiment(name)
    time, signals = stored_result(name)
    declarations, equations = [], []
    for k, (signal, values) in enumerate(signals.items(), 1):
        span = max(values.max() - values.min(), ROUNDING * abs(values).max(), LEAST)
        stored = ", ".join(f"{v:.7g}" for v in values[EVERY::EVERY])
        declarations.append(
            f"    Compared compared{k}(\n      interval={time[EVERY]:.10g},\n"
            f"      moment={0.05 * interval:.6g},\n"
            f"      tolerance={SHARE * span:.6g},\n      stored={{{stored}}});\n"
        )
        equations.append(f"    compared{k}.u = {signal};\n")
    run = f"experiment(StopTime={stop:g}, Interval={interval:g}, Tolerance=1e-6)"
    return "".join(
        [
            f'\n  model {short} "{short} and its stored result"\n    extends {name};\n',
            *declarations,
            "  equation\n",
            *equations,
            f"    annotation ({run});\n  end {short};\n",
        ]
    )


def package() -> str:
    """Return the text of the test package."""
    models = "".join(map(model_of, EXAMPLES))
    uses = f'uses(Modelica(version="4.0.0"), IT2Hysteresis(version="{LIBRARY_VERSION}"))'
    return f"{HEAD}{models}  annotation ({uses});\nend IT2HysteresisTest;\n"


if __name__ == "__main__":
    PACKAGE.parent.mkdir(exist_ok=True)
    write_atomically(PACKAGE, package().encode())
    print(PACKAGE.relative_to(LIBRARY.parents[1]))
