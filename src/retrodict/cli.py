"""The commands, thin: read a scene, reconstruct, report."""

from __future__ import annotations

import gc
import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

import retrodict
from retrodict.progress import Progress, printable, reporting

if TYPE_CHECKING:
    from rich.console import Console

    from retrodict.live import Session
    from retrodict.scene import Scene

BAD_INPUT, DIFFERS, INTERRUPTED = 2, 3, 130
_LOADING, _WRITING = "loading the libraries", "writing the results"  # stages

app = typer.Typer(
    name="retrodict",
    help="Reconstructs vehicle collisions and says how sure it is.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


class UnitChoice(StrEnum):
    """Units that results are given in."""

    si = "si"
    us = "us"


# spelled out, not taken from `inference.samplers`: that would import JAX for --help
MethodChoice = StrEnum(
    "MethodChoice", ["nuts", "importance", "smc", "laplace", "monte-carlo", "linear"]
)
AutoChoice = StrEnum(
    "AutoChoice", ["auto", "nuts", "importance", "smc", "laplace", "monte-carlo", "linear"]
)
ExactChoice = StrEnum("ExactChoice", ["importance", "nuts", "smc"])

OutFolder = Annotated[
    Path | None, typer.Option(help="folder for the results [default: out/NAME-OF-THE-SCENE]")
]
ModelName = Annotated[
    str, typer.Option(help="a rung's name, or auto for the one that the ladder chooses")
]
SceneFile = Annotated[Path, typer.Argument(help="the scene file (TOML)", show_default=False)]


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"retrodict {retrodict.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="the version")
    ] = False,
) -> None:
    pass


@app.command()
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
    from retrodict.scene.plausibility import plausibility_warnings
    from retrodict.scene.quantities import describe

    if scene.is_dir():
        if plot:
            _fail(f"--plot {plot}: {scene} is a folder of results; name a scene file")
        _check_results(scene)
        return
    found = _load(scene)
    uncertain = sum(m.sd > 0 for m in found.inputs().values())
    asked = ", ".join(describe(name)[0] for name in found.question)
    line = (
        f"{scene}: {found.title}: fine. It asks for {asked}. "
        f"{len(found.evidence())} items of evidence, "
        f"{len(found.inputs())} inputs, {uncertain} of them uncertain"
    )
    typer.echo(printable(line))
    for warning in plausibility_warnings(found):
        typer.echo(printable(f"  warning: {warning}"))
    if plot:
        _draw(found, plot, units)


@app.command()
def vehicles() -> None:
    """List the classes and models of vehicles that a scene may name in place of numbers."""
    from rich.console import Console

    from retrodict.report.vehicles import print_vehicles

    print_vehicles(Console())


@app.command("import")
def import_(
    file: Annotated[
        Path,
        typer.Argument(help="survey points (CSV), a drawing (DXF) or a recorder's table (CSV)"),
    ],
    map_file: Annotated[
        Path,
        typer.Option("--map", help="the map (TOML): what the file holds and what the scene takes"),
    ],
    into: Annotated[Path, typer.Option(help="the scene file (TOML) that takes it")],
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="show what would be taken, and write nothing")
    ] = False,
) -> None:
    """Take evidence from another program's file into a scene file, each value with its source."""
    from rich.console import Console

    from retrodict.interchange.importing import import_evidence
    from retrodict.report.files import write_whole
    from retrodict.report.imported import print_import
    from retrodict.report.libraries import MissingLibrary, imported
    from retrodict.scene import SceneError

    try:
        if file.suffix.lower() == ".dxf":
            imported("ezdxf", "a DXF file", "interchange")
        found = import_evidence(file, map_file, into)
    except SceneError as error:
        _fail(str(error))
    except MissingLibrary as error:
        _fail(str(error), 1)
    console = Console()
    print_import(found, console)
    if dry_run:
        return
    try:
        write_whole(into, found.text.encode())
    except OSError as error:
        _fail(f"{into}: cannot write the scene file: {error}", 1)
    _name(into, console)


def _draw(scene: Scene, file: Path, units: UnitChoice) -> None:
    """Write a picture of a scene."""
    from retrodict.report.drawing import IMAGES
    from retrodict.report.figure_scene import plan_figure
    from retrodict.report.files import write_whole

    image = IMAGES.get(file.suffix.lower())
    if image is None:
        *most, last = IMAGES
        _fail(f"--plot {file}: write a file that ends in {', '.join(most)} or {last}")
    try:
        write_whole(file, image(plan_figure(scene, units.value)))
    except OSError as error:
        _fail(f"--plot {file}: cannot write the picture: {error}", 1)
    typer.echo(printable(str(file)))


def _check_results(folder: Path) -> None:
    """Whether all files of a folder of results come from one run."""
    from retrodict.findings.summary import SUMMARY, read_summary, strangers

    if read_summary(folder) is None:
        _fail(f"{folder}: no results are there: {SUMMARY} is missing or damaged")
    if others := strangers(folder):
        _fail(
            f"{folder}: not of the run that {SUMMARY} is of: {', '.join(others)}; "
            "reconstruct the scene anew"
        )
    typer.echo(printable(f"{folder}: fine. All files are those that {SUMMARY} was written with"))


@app.command()
def reconstruct(
    scene: SceneFile,
    out: OutFolder = None,
    model: ModelName = "auto",
    method: Annotated[
        AutoChoice,
        typer.Option(help="how to draw; auto: nuts, and smc where some wheel rolls or nuts fails"),
    ] = AutoChoice.auto,
    chains: Annotated[int, typer.Option(min=1, max=64, help="chains, or replicates")] = 4,
    draws: Annotated[
        int | None,
        typer.Option(min=4, max=1_000_000, help="draws kept of each chain [default: the method's]"),
    ] = None,
    warmup: Annotated[int, typer.Option(min=50, max=100_000, help="iterations before them")] = 150,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, help="of every random number")] = 0,
    units: Annotated[UnitChoice, typer.Option(help="units of the results")] = UnitChoice.si,
    exceeds: Annotated[
        list[str] | None,
        typer.Option(help='ask how probable it is: "speed_b > 45 mph"; may be repeated'),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="go on with a run that was interrupted")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="print errors only")] = False,
) -> None:
    """Reconstruct a collision: posterior, table, figures and report."""
    with _working(quiet) as progress:
        found = _asking(_load(scene), exceeds or [])
        folder = _folder(out, found.name)
        progress(_LOADING, 0, 1)

        from retrodict.report.drawing_process import DrawingProcess

        drawing = DrawingProcess()  # it imports while this process does

        from retrodict.result import CHAINS

        chains_file = folder / CHAINS if resume else None
        if chains_file and not chains_file.is_file():
            _fail(
                f"--resume: {chains_file} is missing: no run was interrupted there; "
                "leave --resume out"
            )
        _known_rung(model, auto=True)

        from retrodict.api import reconstruct as run
        from retrodict.inference import Interrupted, Unanswerable

        try:
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
            progress(_WRITING, 0, 1)

            # not sooner: it imports xarray, which the run does while programs load
            from retrodict.findings.summary import holds_answer

            stays = not result.outcome.complete and holds_answer(folder)
            result.save(folder, units.value, drawing)
            progress(_WRITING, 1, 1)
        except Unanswerable as error:
            _fail(f"{scene}: {error}")
        except ValueError as error:
            if chains_file is None:
                raise
            _fail(f"--resume: {error}")
        except Interrupted as error:
            _fail(f"{scene}: {error}", INTERRUPTED)
        except OSError as error:
            _fail(f"{folder}: cannot write the results: {error}", 1)

    from rich.console import Console

    from retrodict.report.terminal import print_summary

    console = Console(quiet=quiet)
    print_summary(result.findings, console, units.value)
    _name(folder / "report.html", console)
    if stays:
        again = "; --resume goes on with this one" if result.outcome.unfinished else ""
        console.print(f"It is that of the run before, which was finished{again}.")
    if not result.outcome.complete:
        raise typer.Exit(INTERRUPTED)


@app.command()
def explore(
    scene: SceneFile,
    out: OutFolder = None,
    model: ModelName = "auto",
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, help="of every random number")] = 0,
    units: Annotated[UnitChoice, typer.Option(help="units that come first")] = UnitChoice.si,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="of the page; 0 for one that is free")
    ] = 0,
    browser: Annotated[bool, typer.Option(help="open the page in a browser")] = True,
    quiet: Annotated[bool, typer.Option("--quiet", help="print the page's address only")] = False,
) -> None:
    """Change a scene with sliders on a local page, and watch its answer. Ctrl-C ends it."""
    with _working(quiet) as progress:
        found = _load(scene)
        folder = _folder(out, found.name)
        progress(_LOADING, 0, 1)

        from retrodict.report.libraries import MissingLibrary, imported

        try:
            imported("nicegui", "the page", "explore")
        except MissingLibrary as error:
            _fail(str(error), 1)

        from retrodict.explore.server import address, listen, serve

        try:
            listening = listen(port)
        except OSError as error:
            _fail(f"--port {port}: {error.strerror}; choose another, or leave it out", 1)

        _known_rung(model, auto=True)

        from retrodict.explore.explorer import Explorer, Setting
        from retrodict.inference import Unanswerable
        from retrodict.live import session
        from retrodict.studies.ladder import allowed

        try:
            models = tuple(allowed(found))
        except Unanswerable as error:
            _fail(f"{scene}: {error}")
        if model not in ("auto", *models):
            _fail(f"--model {model}: this scene allows auto and {', '.join(models)}")
        setting = Setting(models, folder, scene.resolve(), units.value)

    def opened(of: Scene, by: str, progress: Progress) -> Session:
        return session(of, model=by, seed=seed, progress=progress)

    typer.echo(f"{address(listening)} (Ctrl-C ends it)")
    with suppress(KeyboardInterrupt):
        serve(Explorer(found, opened, model), setting, listening, browser=browser)
    # at once: a computation that nobody waits for would hold up the interpreter's own end
    sys.stdout.flush()
    os._exit(0)


@app.command()
def report(
    result: Annotated[
        Path, typer.Argument(help="folder of a result, as reconstruct wrote it", show_default=False)
    ],
    formats: Annotated[
        str, typer.Option("--format", help="html, pdf, docx, or several with commas")
    ] = "html",
    case: Annotated[
        Path | None, typer.Option(help="case file (TOML): number, examiner, attachments …")
    ] = None,
    units: Annotated[
        UnitChoice | None, typer.Option(help="units that come first [default: the case's, or si]")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="folder for the report [default: that of the result]")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="print errors only")] = False,
) -> None:
    """Write the report of a finished run as HTML page, PDF or Word document."""
    from retrodict.report.document import UnknownFormat, document_of, renderers, write_reports
    from retrodict.scene import SceneError
    from retrodict.scene.case import load_case

    try:
        wanted = list(renderers(formats.split(",")))
        known = None if case is None else load_case(case)
    except UnknownFormat as error:
        _fail(f"--format {formats}: {error}")
    except SceneError as error:
        _fail(str(error))
    with _working(quiet) as progress:
        folder = result if out is None else _folder(out, "report")
        progress(_LOADING, 0, 1)

        from retrodict.findings.stored import NotStored
        from retrodict.report.libraries import MissingLibrary, arviz_without_jax
        from retrodict.report.pdf import NoGlyph
        from retrodict.result import load

        arviz_without_jax()

        try:
            found = load(result)
            progress(_WRITING, 0, 1)
            chosen = units.value if units else (known and known.units) or "si"
            document = document_of(found.findings_for(known), found.outcome, chosen, known)
            files = write_reports(document, folder, wanted)
            progress(_WRITING, 1, 1)
        except (NotStored, SceneError) as error:
            _fail(str(error))
        except (MissingLibrary, NoGlyph) as error:
            _fail(str(error), 1)
        except OSError as error:
            _fail(f"{folder}: cannot write the report: {error}", 1)

    from rich.console import Console

    for file in files:
        _name(file, Console(quiet=quiet))


@app.command()
def export(
    result: Annotated[
        Path,
        typer.Argument(
            help="folder of a result, as reconstruct wrote it, or an archive", show_default=False
        ),
    ],
    formats: Annotated[
        str | None,
        typer.Option(
            "--format",
            help="motion, dxf, svg, tables, netcdf, parquet, or several with commas [default: all]",
        ),
    ] = None,
    draw: Annotated[
        list[str] | None,
        typer.Option(
            help="whose motion: median, a percentage of the sought speed, or a draw's number; may be "
            "repeated [default: median, 5%, 95%]"
        ),
    ] = None,
    rate: Annotated[float, typer.Option(help="of motions, frames a second")] = 30.0,
    before: Annotated[
        float, typer.Option(help="how long before the impact motions begin, s")
    ] = 1.0,
    units: Annotated[UnitChoice, typer.Option(help="units of tables")] = UnitChoice.si,
    out: Annotated[
        Path | None, typer.Option(help="folder for the files [default: RESULT/export]")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="print errors only")] = False,
) -> None:
    """Write a finished run for other programs: motions, DXF, SVG, tables and draws."""
    with _working(quiet) as progress:
        if out is None and result.is_file():
            _fail(f"{result}: an archive is left as it is; name a folder for the files with --out")
        folder = _folder(result / "export" if out is None else out, "export")
        progress(_LOADING, 0, 1)

        from retrodict.report.libraries import MissingLibrary, arviz_without_jax

        arviz_without_jax()

        from retrodict.findings.run_outs import NoMotion
        from retrodict.findings.stored import NotStored
        from retrodict.report.archive import NotArchived
        from retrodict.report.export import Asked, NotExported, checked
        from retrodict.result import load

        try:
            wanted = checked(() if formats is None else formats.split(","), Asked((), rate, before))
            found = load(result)
            progress(_WRITING, 0, 1)
            files = found.export(
                folder, wanted, draws=draw or (), rate=rate, before=before, units=units.value
            )
            progress(_WRITING, 1, 1)
        except (NotStored, NotArchived, NotExported, NoMotion) as error:
            _fail(str(error))
        except MissingLibrary as error:
            _fail(str(error), 1)
        except OSError as error:
            _fail(f"{folder}: cannot write the files: {error}", 1)

    from rich.console import Console

    console = Console(quiet=quiet)
    for file in files:
        _name(file, console)
    if not found.checks.passed:
        console.print(found.findings.verdict, highlight=False, markup=False)


@app.command()
def archive(
    result: Annotated[
        Path, typer.Argument(help="folder of a result, as reconstruct wrote it", show_default=False)
    ],
    case: Annotated[
        Path | None, typer.Option(help="case file (TOML); its attachments' SHA-256 are recorded")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="the file [default: beside the folder, .retrodict.zip]")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="print errors only")] = False,
) -> None:
    """Put a result and all that it came from into one file that can be verified and run anew."""
    with _working(quiet) as progress:
        progress(_LOADING, 0, 1)

        from retrodict.findings.stored import NotStored
        from retrodict.report.archive import SUFFIX, read_archive
        from retrodict.report.libraries import arviz_without_jax
        from retrodict.result import load
        from retrodict.scene import SceneError

        arviz_without_jax()

        file = out or result.resolve().with_name(f"{result.resolve().name}{SUFFIX}")
        try:
            found = load(result)
            progress(_WRITING, 0, 1)
            link = read_archive(found.archive(file, case)).link
            progress(_WRITING, 1, 1)
        except (NotStored, SceneError) as error:
            _fail(str(error))
        except OSError as error:
            _fail(f"{file}: cannot write the archive: {error}", 1)

    from rich.console import Console

    console = Console(quiet=quiet)
    _name(file, console)
    console.print(f"Its chain of hashes ends in {link}", highlight=False, soft_wrap=True)


@app.command()
def replay(
    archive: Annotated[Path, typer.Argument(help="an archive", show_default=False)],
    quiet: Annotated[bool, typer.Option("--quiet", help="print errors only")] = False,
) -> None:
    """Verify an archive, run it anew, and say which numbers come out the same."""
    with _working(quiet) as progress:
        progress(_LOADING, 0, 1)

        from retrodict.api import replay as run
        from retrodict.inference import Interrupted, Unanswerable
        from retrodict.report.archive import NotArchived
        from retrodict.scene import SceneError

        try:
            found = run(archive, progress=progress)
        except NotArchived as error:
            _fail(str(error))
        except (SceneError, Unanswerable, ValueError) as error:
            _fail(f"{archive}: {error}")
        except Interrupted as error:
            _fail(f"{archive}: {error}", INTERRUPTED)
        except OSError as error:
            _fail(f"{archive}: cannot be read: {error}")

    from rich.console import Console

    from retrodict.report.reproduction import reproduction_lines

    console = Console(quiet=quiet)
    for line in reproduction_lines(found):
        console.print(printable(line), highlight=False, markup=False, soft_wrap=True)
    if not found.reproduced:
        raise typer.Exit(DIFFERS)


@app.command()
def ladder(
    scene: SceneFile,
    out: OutFolder = None,
    share: Annotated[
        float,
        typer.Option(help="of its standard deviation that a fuller model may move an answer by"),
    ] = 0.25,
    factor: Annotated[
        float, typer.Option(help="by which a fuller model may widen or narrow it")
    ] = 1.25,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, help="of every random number")] = 0,
    units: Annotated[UnitChoice, typer.Option(help="units of the results")] = UnitChoice.si,
    quiet: Annotated[bool, typer.Option("--quiet", help="print errors only")] = False,
) -> None:
    """Reconstruct on every model that the scene allows, and choose the lowest that will do."""
    with _working(quiet) as progress:
        found = _load(scene)
        if not (0 < share < math.inf and 1 < factor < math.inf):
            _fail(f"--share {share:g} --factor {factor:g}: share is above 0, and factor above 1")
        folder = _folder(out, found.name)
        progress(_LOADING, 0, 1)

        from retrodict.api import ladder as compare_models
        from retrodict.inference import Unanswerable
        from retrodict.report.ladder import write_ladder

        try:
            comparison = compare_models(
                found, seed=seed, share=share, factor=factor, progress=progress
            )
            progress(_WRITING, 0, 1)
            write_ladder(comparison, folder)
            progress(_WRITING, 1, 1)
        except Unanswerable as error:
            _fail(f"{scene}: {error}")
        except OSError as error:
            _fail(f"{folder}: cannot write the results: {error}", 1)

    from rich.console import Console

    from retrodict.report.terminal import print_ladder

    console = Console(quiet=quiet)
    print_ladder(comparison, console, units.value)
    _name(folder / "ladder.json", console)
    if not comparison.complete:
        raise typer.Exit(INTERRUPTED)


@app.command()
def calibrate(
    model: Annotated[str, typer.Option(help="a rung's name")] = "planar-moment+wheels",
    method: Annotated[ExactChoice, typer.Option(help="how to draw")] = ExactChoice.importance,
    simulations: Annotated[int, typer.Option(min=2, max=100_000, help="how many")] = 1000,
    scene: Annotated[
        Path | None, typer.Option(help="the design, a scene file [default: the package's]")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, help="of every random number")] = 0,
    out: Annotated[
        Path | None,
        typer.Option(help="folder for the results [default: out/calibration/MODEL-METHOD]"),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="print errors only")] = False,
) -> None:
    """Simulate crashes and reconstruct them: are the posteriors as sure as they may be?"""
    with _working(quiet) as progress:
        found = None if scene is None else _load(scene)
        progress(_LOADING, 0, 1)

        _known_rung(model, auto=False)
        folder = _folder(out, f"calibration/{model}-{method.value}")

        from retrodict.api import calibrate as run

        try:
            done = run(
                found,
                model=model,
                method=method.value,
                simulations=simulations,
                seed=seed,
                out=folder,
                progress=progress,
            )
        except ValueError as error:
            _fail(str(error))
        except OSError as error:
            _fail(f"{folder}: cannot write the results: {error}", 1)

    from rich.console import Console

    from retrodict.report.calibration import print_calibration

    console = Console(quiet=quiet)
    print_calibration(done, console)
    _name(folder / "calibration.json", console)
    if not done.complete:
        raise typer.Exit(INTERRUPTED)


@app.command()
def validate(
    folder: Annotated[
        Path, typer.Argument(help="holds the cases: folders with scene.toml and truth.toml")
    ] = Path("examples"),
    out: Annotated[Path, typer.Option(help="folder for the results")] = Path("out/validation"),
    model: ModelName = "auto",
    method: Annotated[MethodChoice, typer.Option(help="how to draw")] = MethodChoice.nuts,
    units: Annotated[UnitChoice, typer.Option(help="units of the results")] = UnitChoice.si,
    quiet: Annotated[bool, typer.Option("--quiet", help="print errors only")] = False,
) -> None:
    """Reconstruct staged collisions, and compare with the speeds that were measured."""
    with _working(quiet) as progress:
        _folder(out, "validation")
        progress(_LOADING, 0, 1)

        _known_rung(model, auto=True)
        from retrodict.api import validate as run

        try:
            done = run(
                folder,
                model=model,
                method=method.value,
                units=units.value,
                out=out,
                progress=progress,
            )
        except ValueError as error:
            _fail(str(error))
        except OSError as error:
            _fail(f"{out}: cannot write the results: {error}", 1)

    from rich.console import Console

    from retrodict.report.validation import print_validation

    console = Console(quiet=quiet)
    print_validation(done, console, units.value)
    _name(out / "validation.md", console)
    if done.faults:
        _fail("\n".join(done.faults))
    if not done.complete:
        raise typer.Exit(INTERRUPTED)


@contextmanager
def _working(quiet: bool) -> Iterator[Progress]:
    """A context with a progress display, in which what stops the work is reported in one line."""
    # imports and tracing make much and drop little: fewer sweeps save a second of a first run
    gc.set_threshold(100_000)
    try:
        with reporting(quiet=quiet) as progress:
            yield progress
    except KeyboardInterrupt:
        _fail("interrupted", INTERRUPTED)
    except RuntimeError as error:
        platforms = os.environ.get("JAX_PLATFORMS")
        if platforms is None or "backend" not in str(error):
            raise
        _fail(
            f"JAX_PLATFORMS={platforms}: {error}".splitlines()[0] + "; unset it, or set it to cpu"
        )


def _name(file: Path, console: Console) -> None:
    """Say where results are, so that it can be copied."""
    console.print(printable(str(file)), highlight=False, markup=False, soft_wrap=True)


def _load(path: Path) -> Scene:
    from retrodict.scene import SceneError, load_scene

    try:
        return load_scene(path)
    except SceneError as error:
        _fail(str(error))


def _asking(scene: Scene, propositions: list[str]) -> Scene:
    """The scene with these questions besides its own."""
    from retrodict.scene.asked import read_proposition
    from retrodict.scene.errors import shown
    from retrodict.scene.units import QuantityError

    asked = []
    for text in propositions:
        try:
            asked.append(read_proposition(text))
        except QuantityError as error:
            _fail(f"--exceeds {shown(text)}: {error}")
    probabilities = (*scene.questions.probabilities, *asked)
    return replace(scene, questions=replace(scene.questions, probabilities=probabilities))


def _known_rung(model: str, *, auto: bool) -> None:
    """Refuse a name that no rung has; auto may do too."""
    from retrodict.models import RUNGS

    if model not in RUNGS and not (auto and model == "auto"):
        _fail(f"--model {model}: choose {'auto or ' if auto else ''}one of {', '.join(RUNGS)}")


def _folder(out: Path | None, name: str) -> Path:
    """Where results go; found out before the work whether they can go there."""
    if out is None and name.strip(". ") == "":
        _fail("the scene file's name gives results no name: choose a folder with --out")
    if out == Path():  # an empty option, rarely meant as the current folder
        _fail("--out is empty, or the current folder: name a folder for the results")
    folder = Path("out") / name if out is None else out
    nearest = folder
    while not nearest.exists() and nearest != nearest.parent:
        nearest = nearest.parent
    if not nearest.is_dir():
        _fail(f"--out {folder}: {nearest} is a file, not a folder; choose another folder")
    return folder


def _fail(line: str, status: int = BAD_INPUT) -> NoReturn:
    print(printable(line), file=sys.stderr)  # not by typer, which would write across a bar
    raise typer.Exit(status)
