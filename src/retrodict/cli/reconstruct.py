"""The command `retrodict reconstruct`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from retrodict.cli.options import (
    AutoChoice,
    ModelName,
    OutFolder,
    Quiet,
    ResultUnits,
    SceneFile,
    Seed,
    UnitChoice,
)
from retrodict.cli.running import (
    INTERRUPTED,
    LOADING,
    WRITING,
    fail,
    load_or_fail,
    output_folder,
    print_path,
    refusing,
    require_rung,
    working,
    writing,
)

if TYPE_CHECKING:
    from pathlib import Path

    from retrodict.result import Result
    from retrodict.scene import Scene
    from retrodict.scene.quantities import Units


def reconstruct(
    scene: SceneFile,
    out: OutFolder = None,
    model: ModelName = "auto",
    method: Annotated[
        AutoChoice,
        typer.Option(
            help="how to draw; auto: nuts, or importance where some wheel rolls or nuts fails"
        ),
    ] = AutoChoice.auto,
    chains: Annotated[int, typer.Option(min=1, max=64, help="chains, or replicates")] = 4,
    draws: Annotated[
        int | None,
        typer.Option(min=4, max=1_000_000, help="draws kept of each chain [default: the method's]"),
    ] = None,
    warmup: Annotated[int, typer.Option(min=50, max=100_000, help="iterations before them")] = 150,
    seed: Seed = 0,
    units: ResultUnits = UnitChoice.si,
    exceeds: Annotated[
        list[str] | None,
        typer.Option(help='ask how probable it is: "speed_b > 45 mph"; may be repeated'),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="go on with a run that was interrupted")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Reconstruct a collision: posterior, table, figures and report."""
    with working(quiet) as progress:
        found = _asking(load_or_fail(scene), exceeds or [])
        folder = output_folder(out, found.name)
        progress(LOADING, 0, 1)

        chains_file = _chains_of(folder) if resume else None
        require_rung(model, auto=True)

        from retrodict.api import reconstruct as run
        from retrodict.inference import Interrupted, Unanswerable

        with (
            refusing(Unanswerable, prefix=f"{scene}: "),
            refusing(Interrupted, prefix=f"{scene}: ", status=INTERRUPTED),
            refusing(*([ValueError] if chains_file else []), prefix="--resume: "),
            writing(folder),
        ):
            result = run(
                found,
                model=model,
                method=method.value,
                chains=chains,
                draws=draws,
                warmup=warmup,
                seed=seed,
                progress=progress,
                resume=chains_file,
            )
            progress(WRITING, 0, 1)

            # not sooner: it imports xarray, which the run does while programs load
            from retrodict.findings.summary import holds_answer

            stays = not result.outcome.complete and holds_answer(folder)
            result.save(folder, units.value)
            progress(WRITING, 1, 1)

    _print(result, folder, units.value, stays, quiet)
    if not result.outcome.complete:
        raise typer.Exit(INTERRUPTED)


def _print(result: Result, folder: Path, units: Units, stays: bool, quiet: bool) -> None:
    """Print the summary and where the report is; `stays` says that it is of the run before."""
    from rich.console import Console

    from retrodict.report.terminal import print_summary

    console = Console(quiet=quiet)
    print_summary(result.findings, console, units)
    print_path(folder / "report.html", console)
    if stays:
        again = "; --resume goes on with this one" if result.outcome.unfinished else ""
        console.print(f"This report is from the previous, completed run{again}.")


def _chains_of(folder: Path) -> Path:
    """The file by which an interrupted run goes on."""
    from retrodict.result import CHAINS

    if not (file := folder / CHAINS).is_file():
        fail(f"--resume: {file} is missing: no run was interrupted there; leave --resume out")
    return file


def _asking(scene: Scene, propositions: list[str]) -> Scene:
    """The scene with these propositions added to its questions."""
    from retrodict.scene.asked import read_proposition
    from retrodict.scene.errors import shown
    from retrodict.scene.units import QuantityError

    asked = []
    for text in propositions:
        try:
            asked.append(read_proposition(text))
        except QuantityError as error:
            fail(f"--exceeds {shown(text)}: {error}")
    probabilities = (*scene.questions.probabilities, *asked)
    return replace(scene, questions=replace(scene.questions, probabilities=probabilities))
