"""Run a command and show that it is at work, without all that it prints.

Usage: watch.py TITLE COMMAND [ARGUMENT...]

On a terminal one line changes: the time, and what the command printed last. Elsewhere such a line
appears every ten seconds. If the command fails, everything that it printed follows.
"""

import shutil
import subprocess
import sys
import threading
import time

REFRESH = 0.2
SPARSE = 10.0
WIDTH = 80


def watch(title: str, command: list[str]) -> int:
    """Run the command to its end; return its exit code."""
    start = time.monotonic()
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8", errors="replace"
    )
    printed: list[str] = []
    reader = threading.Thread(target=_read, args=(process, printed), daemon=True)
    reader.start()
    on_terminal = sys.stdout.isatty()
    _show(f"{title} ...", on_terminal)
    while reader.is_alive():
        reader.join(REFRESH if on_terminal else SPARSE)
        if reader.is_alive():
            seconds = time.monotonic() - start
            last = printed[-1][:WIDTH] if printed else ""
            _show(f"{title}: {seconds:.0f} s  {last}", on_terminal)
    code = process.wait()
    outcome = "done" if code == 0 else "failed"
    _show(f"{title}: {outcome} after {time.monotonic() - start:.0f} s", on_terminal)
    if on_terminal:
        print()
    if code:
        print("\n".join(printed), file=sys.stderr)
    return code


def _read(process: subprocess.Popen, printed: list[str]) -> None:
    printed.extend(line.strip() for line in process.stdout if line.strip())


def _show(line: str, on_terminal: bool) -> None:
    if on_terminal:
        line = "\r\033[K" + line[: shutil.get_terminal_size().columns - 1]
    print(line, end="" if on_terminal else "\n", flush=True)


if __name__ == "__main__":
    try:
        sys.exit(watch(sys.argv[1], sys.argv[2:]))
    except KeyboardInterrupt:
        sys.exit(130)
