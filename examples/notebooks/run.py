"""Runs the notebooks of this folder from top to bottom, each in a kernel of its own.

`python3 -m uv run --group notebooks python examples/notebooks/run.py` runs all of them and changes
none; numbers after it, such as `1 4`, run those, and `--jobs 2` runs two at a time. `--write` keeps
what they show, without what differs from run to run.
"""

from __future__ import annotations

import argparse
import base64
import io
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, DeadKernelError
from PIL import Image
from traitlets.config import Config

FOLDER = Path(__file__).parent
WIDTH, COLOURS = 600, 96  # of a figure: pixels, as where the repository is browsed
METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}
LONGEST = 600  # seconds that a cell may take, most of them to compile


def run(path: Path) -> nbformat.NotebookNode:
    """The notebook as it is after a run in its own folder.

    Args:
        path: of the notebook.

    Raises:
        CellExecutionError: a cell raised an error; the message has it.
    """
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook,
        timeout=LONGEST,
        kernel_name="python3",
        record_timing=False,
        startup_timeout=LONGEST,
        config=Config(KernelManager={"transport_encryption": "auto"}),
        resources={"metadata": {"path": str(path.parent)}},
    )
    return client.execute()


def settled(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """The notebook without counts, metadata, standard error and the places where progress was."""
    notebook.metadata = nbformat.from_dict(METADATA)
    for cell in notebook.cells:
        cell.metadata = nbformat.from_dict({})
        if cell.cell_type != "code":
            continue
        cell.execution_count = None
        cell.outputs = [each for each in cell.outputs if _shown(each)]
        for each in cell.outputs:
            if "execution_count" in each:
                each.execution_count = None
            if "metadata" in each:
                each.metadata = nbformat.from_dict({})
            if "image/png" in each.get("data", {}):
                each.data["image/png"] = _small(each.data["image/png"])
    return notebook


def _small(png: str) -> str:
    """A figure (base64) that is as wide as where it is looked at, in few colours."""
    with Image.open(io.BytesIO(base64.b64decode(png))) as image:
        figure = image.convert("RGB")
    if figure.width > WIDTH:
        height = round(figure.height * WIDTH / figure.width)
        figure = figure.resize((WIDTH, height), Image.Resampling.LANCZOS)
    small = io.BytesIO()
    few = figure.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few.save(small, "PNG", optimize=True)
    return base64.b64encode(small.getvalue()).decode()


def _shown(output: nbformat.NotebookNode) -> bool:
    """Whether there is something to see that is not the machine's own."""
    return output.get("name") != "stderr" and any(output.get("data", {"text": True}).values())


def attempt(path: Path, write: bool) -> tuple[bool, str]:
    """Run a notebook: whether no cell failed, and a line on it or the error.

    Args:
        path: of the notebook.
        write: whether to keep what it shows.
    """
    since = time.monotonic()
    try:
        notebook = run(path)
    except (CellExecutionError, DeadKernelError) as error:
        return False, f"{path.name}: FAILED\n{error}"
    if write:
        nbformat.write(settled(notebook), path)
    return True, f"{path.name}: {time.monotonic() - since:.0f} s"


def main() -> int:
    """Run what was asked for; the exit status is the number of notebooks that failed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("numbers", nargs="*", type=int, help="of notebooks; none for all")
    parser.add_argument("--write", action="store_true", help="keep what they show")
    parser.add_argument("--jobs", type=int, default=1, help="number of notebooks at a time")
    asked = parser.parse_args()
    paths = [
        path
        for path in sorted(FOLDER.glob("[0-9]*.ipynb"), reverse=True)  # the last ones take longest
        if not asked.numbers or int(path.name[:2]) in asked.numbers
    ]
    failed = 0
    with ProcessPoolExecutor(asked.jobs, get_context("spawn")) as pool:
        for begun in [pool.submit(attempt, path, asked.write) for path in paths]:
            fine, line = begun.result()
            failed += not fine
            print(line, file=sys.stdout if fine else sys.stderr, flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(main())
