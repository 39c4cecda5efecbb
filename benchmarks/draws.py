"""Have a renaming or a rewrite moved any number? Digests of the draws of five scenes, seeds 0 to 4.

python3 -m uv run python -m benchmarks.draws FILE [seeds]

Writes FILE where there is none; else compares with it, and ends with status 1 where a digest differs.
The draws of one seed are equal to the bit only on one machine with one set of versions: FILE is made at
the commit before, and is not kept.
"""

from __future__ import annotations

import hashlib
import json
import sys
from pathlib import Path

import numpy as np

from retrodict import load_scene
from retrodict.inference.reconstruct import reconstruct
from retrodict.options import RunOptions

HERE = Path(__file__).parents[1]
SCENES = {
    "locked": "examples/brach-1977/scene.toml",
    "berm": "examples/brach-1977-berm/scene.toml",
    "wheels": "examples/ricsac-06/scene.toml",
    "rolling": "tests/data/valley.toml",
    "two modes": "tests/data/low-closing.toml",
}
METHODS = "importance", "nuts"


def digests(seeds: int) -> dict[str, str]:
    """Of all draws of each scene, method and seed."""
    found = {}
    for name, file in SCENES.items():
        scene = load_scene(HERE / file)
        for method in METHODS[: 1 if name == "rolling" else None]:  # nuts takes minutes there
            for seed in range(seeds):
                outcome = reconstruct(
                    scene, RunOptions(method=method, draws=250, warmup=100, seed=seed)
                )
                print_ = hashlib.sha256()
                for key, values in sorted(outcome.idata["posterior"].to_dataset().items()):
                    print_.update(str(key).encode() + np.asarray(values).tobytes())
                found[f"{name}, {method}, seed {seed}"] = print_.hexdigest()[:16]
                print(list(found.items())[-1], flush=True)
    return found


def main(file: Path, seeds: int) -> int:
    """Write the digests, or compare with those that are there."""
    now = digests(seeds)
    if not file.exists():
        file.write_text(json.dumps(now, indent=1) + "\n", "utf-8")
        return 0
    before = json.loads(file.read_text("utf-8"))
    moved = [key for key, digest in now.items() if before.get(key) != digest]
    print(f"{len(now) - len(moved)} of {len(now)} are equal to the bit", *moved, sep="\n")
    return int(bool(moved))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), int(sys.argv[2]) if sys.argv[2:] else 5))
