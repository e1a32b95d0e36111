"""`make bench`: what its summary is made of."""

import importlib.util
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def bench():
    """Return the module; `benchmarks` is no package."""
    spec = importlib.util.spec_from_file_location("bench_of_all", ROOT / "benchmarks" / "bench.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_lines_with_a_verdict_are_kept_and_a_failure_is_told(capsys):
    printed = [
        "a table",
        "plant  0.98   <= 1.00  met",
        "layer 9.6   <= 9 ns missed",
        "nothing missed here",
    ]
    program = f"import sys; print({chr(10).join(printed)!r}); sys.exit(3)"
    code, judged = bench().run([sys.executable, "-c", program])
    assert code == 3 and judged == printed[1:3]
    assert capsys.readouterr().out.splitlines() == printed


def test_a_part_that_fails_keeps_no_other_from_running(monkeypatch, capsys):
    module = bench()
    codes = {"identification.py": 2}
    ran = []

    def run(command):
        ran.append(command)
        code = next((c for name, c in codes.items() if any(name in word for word in command)), 0)
        return code, ["speed 0.9   >= 0.85 met"]

    monkeypatch.setattr(module, "run", run)
    monkeypatch.setattr(sys, "argv", ["bench.py", "--before", "abc"])
    assert module.main() == 1
    lines = capsys.readouterr().out.splitlines()
    assert len(ran) == 6 and "before.py" in ran[0][2]
    assert lines[-2:] == ["6 of 6 limits are met.", "FAILED: identification: ended with 2"]
