"""The command `retrodict check`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from retrodict.cli.options import UnitChoice
from retrodict.cli.running import fail, load_or_fail
from retrodict.progress import printable

if TYPE_CHECKING:
    from retrodict.scene import Scene


def check(
    scene: Annotated[
        Path,
        typer.Argument(help="the scene file (TOML), or a folder of results", show_default=False),
    ],
    plot: Annotated[
        Path | None, typer.Option(help="draw the scene to scale: a .png, .svg or .pdf file")
    ] = None,
    units: Annotated[UnitChoice, typer.Option(help="units of the drawing")] = UnitChoice.si,
) -> None:
    """Validate a scene file and warn of implausible values; or see that results are of one run."""
    from retrodict.scene.plausibility import assumed_approach, plausibility_warnings
    from retrodict.scene.quantities import describe

    if scene.is_dir():
        if plot:
            fail(f"--plot {plot}: {scene} is a folder of results; name a scene file")
        _check_results(scene)
        return
    found = load_or_fail(scene)
    uncertain = sum(m.sd > 0 for m in found.stated().values())
    asked = ", ".join(describe(name)[0] for name in found.question)
    line = (
        f"{scene}: {found.title}: fine. It asks for {asked}. "
        f"{len(found.evidence())} items of evidence, "
        f"{len(found.stated())} inputs, {uncertain} of them uncertain"
    )
    typer.echo(printable(line))
    if assumed := assumed_approach(found):
        typer.echo(printable(f"  assumed: {assumed}"))
    for warning in plausibility_warnings(found):
        typer.echo(printable(f"  warning: {warning}"))
    if plot:
        _draw(found, plot, units)


def _draw(scene: Scene, file: Path, units: UnitChoice) -> None:
    """Write a picture of a scene."""
    from retrodict.report.figures.drawing import IMAGES
    from retrodict.report.figures.scene import plan_figure
    from retrodict.storage.files import write_whole

    image = IMAGES.get(file.suffix.lower())
    if image is None:
        *most, last = IMAGES
        fail(f"--plot {file}: write a file that ends in {', '.join(most)} or {last}")
    try:
        write_whole(file, image(plan_figure(scene, units.value)))
    except OSError as error:
        fail(f"--plot {file}: cannot write the picture: {error}", 1)
    typer.echo(printable(str(file)))


def _check_results(folder: Path) -> None:
    """Whether all files of a folder of results come from one run."""
    from retrodict.findings.summary import SUMMARY, read_summary, strangers

    if read_summary(folder) is None:
        fail(f"{folder}: no results are there: {SUMMARY} is missing or damaged")
    if others := strangers(folder):
        fail(
            f"{folder}: not of the run that {SUMMARY} is of: {', '.join(others)}; "
            "reconstruct the scene anew"
        )
    typer.echo(printable(f"{folder}: fine. All files are those that {SUMMARY} was written with"))
