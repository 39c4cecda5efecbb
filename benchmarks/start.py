"""What whole commands take, imports and reports included: prints a table.

python3 -m uv run --group bench python -m benchmarks.start [python of another installation]

Commands are run in turn, three times each after a first that compiles; where the interpreter of another
installation (an earlier commit's) is given, alternately with it. Linux only: its /proc says what memory
processes share.
"""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks import page
from benchmarks.machine import machine

ROOT = Path(__file__).parents[1]
SCENE = ROOT / "examples" / "brach-1977" / "scene.toml"
REPEATS = 3
HEADINGS = (
    "command",
    "installation",
    "CPU, s",
    "wall, s",
    "modules",
    "largest process, MB",
    "all, MB",
)
_BEAT = 0.25  # s between looks at the memory: each takes the kernel some 10 ms


@dataclass(frozen=True, slots=True)
class Taken:
    """What one run of a command took: seconds, modules of its process, megabytes."""

    cpu: float
    wall: float
    modules: int
    largest: float
    together: float


def commands(folder: Path) -> dict[str, list[str]]:
    """The commands by what they are called; the last reads what the one before it wrote."""
    out = str(folder)
    return {
        "--help": ["--help"],
        "check": ["check", str(SCENE)],
        "reconstruct": ["reconstruct", str(SCENE), "--out", out, "--quiet"],
        "report html,pdf,docx": ["report", out, "--format", "html,pdf,docx", "--quiet"],
    }


def run(python: str, arguments: list[str]) -> Taken:
    """Run a command to its end and look at its memory meanwhile."""
    # counted where the interpreter ends, after all that was imported late
    code = (
        "import atexit, sys; sys.argv[0] = 'retrodict'; "
        "atexit.register(lambda: print(len(sys.modules), file=sys.stderr)); "
        "from retrodict.__main__ import main; main()"
    )
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    process = subprocess.Popen(
        [python, "-P", "-c", code, *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    largest = together = 0.0
    while process.poll() is None:
        each = [_megabytes(pid) for pid in _family(process.pid)]
        largest = max([largest, *(resident for resident, _ in each)])
        together = max(together, sum(share for _, share in each))
        time.sleep(_BEAT)
    wall = time.perf_counter() - begin
    assert process.stderr is not None
    said = process.stderr.read().split()
    if process.returncode:
        raise RuntimeError(f"{' '.join(arguments)}: {' '.join(said)}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Taken(cpu, wall, int(said[-1]), largest, together)


def _family(pid: int) -> Iterator[int]:
    """A process and its descendants."""
    yield pid
    for listed in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            children = listed.read_text().split()
        except OSError:  # it has ended
            continue
        for child in children:
            yield from _family(int(child))


def _megabytes(pid: int) -> tuple[float, float]:
    """Memory of a process: resident, and with shared pages divided among those that share them."""
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0.0, 0.0
    found = {line.split(":")[0]: line.split()[1] for line in lines[1:]}
    return int(found.get("Rss", 0)) / 1024, int(found.get("Pss", 0)) / 1024


def measure(pythons: dict[str, str]) -> Iterator[list[str]]:
    """Rows of the table: medians over the repeats."""
    with TemporaryDirectory() as name:
        for command, arguments in commands(Path(name) / "out").items():
            taken: dict[str, list[Taken]] = {each: [] for each in pythons}
            for python in pythons.values():
                run(python, arguments)
            for _ in range(REPEATS):
                for installation, python in pythons.items():
                    taken[installation].append(run(python, arguments))
            for installation, each in taken.items():
                medians = [
                    statistics.median(getattr(one, field) for one in each)
                    for field in ("cpu", "wall", "modules", "largest", "together")
                ]
                seconds = [f"{value:.2f}" for value in medians[:2]]
                yield [command, installation, *seconds, *(f"{value:.0f}" for value in medians[2:])]


def main(others: list[str]) -> None:
    """Measure this installation, and others beside it."""
    pythons = {"before": others[0]} if others else {}
    rows = [*measure(pythons | {"this": sys.executable})]
    print(machine(("jax", "numpyro", "scipy")), "", *page.table(HEADINGS, rows), sep="\n")


if __name__ == "__main__":
    main(sys.argv[1:])
