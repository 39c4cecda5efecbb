"""Full disks, kills and flipped bits: is anything lost, or mixed without a word?

python3 -m uv run python -m benchmarks.faults

Two runs of the paper's example are made. Their files are then put into one folder in turn while the
process that does it is killed at random moments, or may not write beyond a random size; and bits of the
programs that they left in a cache are flipped. Prints a line for each kind of fault.
"""

from __future__ import annotations

import os
import random
import resource
import subprocess
import sys
import tempfile
import time
from collections import Counter
from multiprocessing import get_context
from pathlib import Path

from retrodict.findings.summary import SUMMARY, read_summary, strangers
from retrodict.inference.density import disk_cache
from retrodict.storage.files import write_together

KILLS, LIMITS, FLIPS = 50, 50, 500
SCENE = Path(__file__).parents[1] / "examples" / "brach-1977" / "scene.toml"


def main() -> None:
    """Make two runs, then break what can be broken."""
    with tempfile.TemporaryDirectory() as name:
        folder, chance = Path(name), random.Random(0)
        runs = [_run(folder, seed) for seed in (0, 1)]
        print("killed while results are put in place:", _counted(_killed(runs, folder, chance)))
        print("no room for a file:", _counted(_full(runs, folder, chance)))
        print("a bit of a cached program flipped:", _counted(_flipped(folder, chance)))


def _counted(found: Counter[str]) -> str:
    return ", ".join(f"{count} {what}" for what, count in sorted(found.items()))


def _run(folder: Path, seed: int) -> dict[str, bytes]:
    """The files of a run, the summary last."""
    out = folder / f"run-{seed}"
    command = [Path(sys.executable).with_name("retrodict"), "reconstruct", SCENE, "--out", out]
    environment = os.environ | {"XDG_CACHE_HOME": str(folder / "cache")}
    asked = [*command, "--seed", str(seed), "--quiet"]
    subprocess.run(asked, check=True, env=environment)
    names = [p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file()]
    return {name: (out / name).read_bytes() for name in sorted(names, key=SUMMARY.__eq__)}


def _state(folder: Path, runs: list[dict[str, bytes]]) -> str:
    """What a folder of results is after a fault."""
    left = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    here = {name: (folder / name).read_bytes() for name in runs[0] if name in left}
    if here in runs:
        return "of one run"
    if read_summary(folder) is None or strangers(folder):
        return "mixed, and reported"
    return "MIXED AND NOT REPORTED"


def _write_for_ever(runs: list[dict[str, bytes]], folder: Path) -> None:
    while True:
        for contents in runs:
            write_together(folder, contents)


def _killed(runs: list[dict[str, bytes]], folder: Path, chance: random.Random) -> Counter[str]:
    found: Counter[str] = Counter()
    for number in range(KILLS):
        target = folder / f"killed-{number}"
        write_together(target, runs[0])
        process = get_context("spawn").Process(target=_write_for_ever, args=(runs, target))
        process.start()
        while (target / SUMMARY).read_bytes() == runs[0][SUMMARY]:  # until it has begun
            time.sleep(0.001)
        time.sleep(chance.uniform(0, 0.2))
        process.kill()
        process.join()
        found[_state(target, runs)] += 1
    return found


def _limited(contents: dict[str, bytes], folder: Path, most: int) -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
    try:
        write_together(folder, contents)
    except OSError:
        sys.exit(3)


def _full(runs: list[dict[str, bytes]], folder: Path, chance: random.Random) -> Counter[str]:
    found: Counter[str] = Counter()
    largest = max(map(len, runs[1].values()))
    target = folder / "full"
    write_together(target, runs[0])
    for _ in range(LIMITS):
        arguments = (runs[1], target, chance.randrange(largest))
        process = get_context("spawn").Process(target=_limited, args=arguments)
        process.start()
        process.join()
        names = {p.relative_to(target).as_posix() for p in target.rglob("*") if p.is_file()}
        kept = process.exitcode == 3 and _state(target, runs) == "of one run"
        found["as before" if kept and names == set(runs[0]) else "CHANGED"] += 1
    return found


def _flipped(folder: Path, chance: random.Random) -> Counter[str]:
    found: Counter[str] = Counter()
    programs = sorted((folder / "cache").rglob("*.bin"))
    for _ in range(FLIPS):
        path = chance.choice(programs)
        whole = path.read_bytes()
        torn, bit = bytearray(whole), chance.randrange(8 * len(whole))
        torn[bit // 8] ^= 1 << bit % 8
        path.write_bytes(torn)
        found["refused" if disk_cache.load(path) is None else "TAKEN"] += 1
        path.write_bytes(whole)
    return found


if __name__ == "__main__":
    main()
