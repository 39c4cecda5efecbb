"""Measures, and rewrites docs/inference.md.

python3 -m uv run --group bench python -m benchmarks.inference [share folder]

With a share of the work (0.05, say) and a folder: a trial, which writes there only.
"""

from __future__ import annotations

import sys
from pathlib import Path

from benchmarks.__main__ import DOCS
from benchmarks.inference.study import main

if __name__ == "__main__":
    if sys.argv[1:]:
        folder = Path(sys.argv[2])
        folder.mkdir(parents=True, exist_ok=True)
        main(folder, float(sys.argv[1]))
    else:
        from benchmarks import page

        main(DOCS / "charts")
        page.refresh(DOCS / "inference.md", page.of_inference(DOCS / "charts"))
