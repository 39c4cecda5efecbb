"""The user's home in a notebook: reconstruct a scene, then look, save and report."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

from retrodict.inference.errors import Interrupted
from retrodict.inference.modes import ModeSearch
from retrodict.inference.outcome import Checks, Outcome
from retrodict.inference.reconstruct import DEFAULT_RUNG
from retrodict.inference.reconstruct import reconstruct as _reconstruct
from retrodict.inference.samplers import checkpoint
from retrodict.progress import Progress, prefixed, shown_in_notebooks, silent
from retrodict.scene.asked import read_proposition
from retrodict.scene.quantities import Units
from retrodict.scene.records import Scene
from retrodict.studies import calibration as _calibration
from retrodict.studies import validation as _validation
from retrodict.studies.calibration import Calibration
from retrodict.studies.ladder import Ladder, allowed, method_for
from retrodict.studies.ladder import ladder as _ladder
from retrodict.studies.validation import Validation

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from retrodict.findings import Findings
    from retrodict.findings.questions import Answered
    from retrodict.findings.reproduction import Reproduction
    from retrodict.report.drawing_process import DrawingProcess
    from retrodict.scene.case import Case


__all__ = [
    "CHAINS",
    "Calibration",
    "Ladder",
    "Result",
    "Validation",
    "calibrate",
    "ladder",
    "load",
    "reconstruct",
    "replay",
    "validate",
]

AUTO = "auto"  # the model that the ladder chooses, and the method that suits the scene
_CHAINS = 4  # unless asked for otherwise, as by the ladder
CHAINS = "chains.npz"  # what an interrupted run needs to go on

ladder = shown_in_notebooks(_ladder)


@dataclass(frozen=True, repr=False)
class Result:
    """A reconstruction: its draws, its checks, its figures and its report.

    Args:
        outcome: what the run came to.
        ladder: what the other models say, where the ladder chose this one.
    """

    outcome: Outcome
    ladder: Ladder | None = None

    @property
    def scene(self) -> Scene:
        """What was measured."""
        return self.outcome.scene

    @property
    def idata(self) -> xr.DataTree:
        """Posterior, prior, predictions and diagnostics, as an ArviZ DataTree in SI units."""
        return self.outcome.idata

    @property
    def checks(self) -> Checks:
        """The verdict on the draws' numerical quality."""
        return self.outcome.checks

    @cached_property
    def findings(self) -> Findings:
        """Every number, sentence and table of the report, computed when first asked for."""
        from retrodict import findings  # imports xarray, which a run does while programs compile

        return findings.compute(self.outcome, self.ladder)

    def summary(self, units: Units = "si") -> pd.DataFrame:
        """The reported quantities in a table.

        Args:
            units: "si" or "us".

        Returns:
            One row a quantity, one column a statistic; quantities that failed a check of their own
            are NaN, and the column `checks` says so.
        """
        from retrodict.findings.summary import summary_frame

        return summary_frame(self.findings, units)

    def probability(self, proposition: str) -> Answered:
        """How probable a proposition about a reported quantity is, given the evidence.

        Args:
            proposition: such as "speed_b > 45 mph" or "40 mph < speed_b < 50 mph", in any unit that a
                scene file may have.

        Returns:
            The answer: `sentences` in words, and `numbers` with `value` and Monte Carlo `error`; no
            numbers where the result is withheld.

        Raises:
            ValueError: it is no such text; the message says what to write instead.
        """
        from retrodict.findings.questions import probability_of

        found = self.findings
        quantities = found.quantities | found.derived
        return probability_of(self.outcome, quantities, read_proposition(proposition))

    def findings_for(self, case: Case | None) -> Findings:
        """The findings, with the answers to a case's questions after those to the scene's.

        Args:
            case: from `load_case`; None where there is none.

        Returns:
            The record.

        Raises:
            SceneError: a question of the case does not fit.
        """
        if case is None or not case.questions:
            return self.findings
        from retrodict.findings.questions import answers_to
        from retrodict.scene.questions import questions_from

        found = self.findings
        # the scene's answers hold these
        asked = replace(
            questions_from(case.questions, "case file"), one_at_a_time=False, checks=False
        )
        quantities = found.quantities | found.derived
        more = answers_to(self.outcome, asked, quantities, found.left_out)
        return replace(found, questions=found.questions + more)

    def plot_posterior(self, units: Units = "si") -> Figure:
        """Marginal posteriors of speed, e, e_m and mu with their intervals."""
        return self._draw("posterior", units)

    def plot_pair(self, units: Units = "si") -> Figure:
        """The joint posterior of speed, e, e_m and mu, pair by pair."""
        return self._draw("pair", units)

    def plot_scene(self, units: Units = "si") -> Figure:
        """The scene from above with measured rest poses and posterior trajectories."""
        return self._draw("scene", units)

    def plot_delta_v(self, units: Units = "si") -> Figure:
        """Delta-v and direction of force (PDOF) of both vehicles with their clouds of draws."""
        return self._draw("delta_v", units)

    def plot_predictive(self, units: Units = "si") -> Figure:
        """What the posterior predicts of every item of evidence, against what was measured."""
        return self._draw("predictive", units)

    def plot_tornado(self, units: Units = "si") -> Figure:
        """The effect of each measurement on each speed that was sought."""
        return self._draw("tornado", units)

    def plot_timeline(self, units: Units = "si") -> Figure:
        """Times and distances before the impact, where the scene's questions ask for them."""
        return self._draw("timeline", units)

    def report(
        self,
        path: str | Path,
        units: Units | None = None,
        case: Case | str | Path | None = None,
    ) -> Path:
        """Write the report as HTML, PDF or Word document, by the suffix of the file.

        Args:
            path: of the file, replaced whole: .html, .pdf or .docx.
            units: "si" or "us" first; None for those of the case, or else SI.
            case: what the expert says, or the path of a case file; None where nothing is stated.

        Returns:
            The path.

        Raises:
            UnknownFormat: no format has that suffix.
            MissingLibrary: the format needs a library that is not installed.
            NoGlyph: no font at hand prints a character of the PDF.
            SceneError: the case file cannot be used.
            OSError: the file could not be written.
        """
        from retrodict.report.document import write_report
        from retrodict.scene.case import load_case

        known = load_case(case) if isinstance(case, str | Path) else case
        chosen = units or (known and known.units) or "si"
        findings = self.findings_for(known)
        return write_report(findings, self.outcome, Path(path), chosen, known)

    def archive(self, path: str | Path, case: str | Path | None = None) -> Path:
        """Write all that the result came from and to as one file, which `replay` verifies and runs anew.

        Args:
            path: of the file, replaced whole; by custom it ends in .retrodict.zip.
            case: path of a case file; its attachments are recorded by their SHA-256.

        Returns:
            The path.

        Raises:
            SceneError: the case file cannot be used.
            OSError: the file could not be written.
        """
        from retrodict.report.archive import archive_bytes
        from retrodict.report.files import write_whole
        from retrodict.report.result_archive import archived

        files = archived(self.findings, self.outcome, self.ladder, Path(case) if case else None)
        return write_whole(Path(path), archive_bytes(files))

    def save(
        self, directory: str | Path, units: Units = "si", drawing: DrawingProcess | None = None
    ) -> Path:
        """Write the result: `load` reads it again.

        The files are posterior.nc, run.json, scene.toml, report.html, figures/*.png,
        figures/scene.svg, summary.json, and chains.npz if the run was interrupted. The summary comes
        last and has the digests of the others, so that a mixture of two runs shows.

        Args:
            directory: made where missing; files of the same names in it are replaced, once all of
                the new ones are written, and others are left alone. Where it holds the answer of a
                run that was finished, an interrupted one leaves that alone and writes chains.npz only.
            units: "si" or "us".
            drawing: a process started ahead to draw the figures; None to draw them here.

        Returns:
            The directory.

        Raises:
            OSError: something could not be written; then nothing in the directory has changed.
        """
        # handed over before the imports and asked for last: all else is done while they are drawn
        begun = drawing.begin(self.findings, self.outcome, units) if drawing else None

        from retrodict.findings.stored import stored
        from retrodict.findings.summary import SUMMARY, holds_answer, summary_json
        from retrodict.report.document import FORMATS, document_of
        from retrodict.report.figures import images, svgs
        from retrodict.report.files import write_together

        directory = Path(directory)
        chains = {CHAINS: self.outcome.unfinished} if self.outcome.unfinished else {}
        if not self.outcome.complete and holds_answer(directory):
            write_together(directory, chains)
            return directory
        drawn = cache(begun or partial(images, self.findings, self.outcome, units))
        document = document_of(self.findings, self.outcome, units, drawn=drawn)
        files = {
            **stored(self.outcome, self.ladder),
            "scene.toml": self.findings.scene_text.text.encode(),
            "report.html": FORMATS["html"](document),
            **{f"figures/{name}.png": image for name, image in drawn().items()},
            **{
                f"figures/{name}.svg": drawing
                for name, drawing in svgs(self.findings, self.outcome, units).items()
            },
            **chains,
        }
        files[SUMMARY] = summary_json(self.findings, files)
        write_together(directory, files)
        if not chains:
            (directory / CHAINS).unlink(missing_ok=True)  # of a run that this one went on with
        return directory

    def _draw(self, name: str, units: Units) -> Figure:
        from retrodict.report.figures import ASKED, FIGURES

        return (FIGURES | ASKED)[name].draw(self.findings, self.outcome, units)

    def __repr__(self) -> str:
        verdict = "passed" if self.checks.passed else "FAILED"
        model, seed = self.outcome.description.name, self.outcome.seed
        return f"<Result of {self.scene.name!r}: {model}, seed {seed}, checks {verdict}>"

    def _repr_html_(self) -> str:
        from retrodict.report.fragments import findings_html

        return findings_html(self.findings)


def load(folder: str | Path) -> Result:
    """The result that was saved in a folder.

    Args:
        folder: that `Result.save`, or `retrodict reconstruct`, wrote to.

    Returns:
        The result, as it was; of an interrupted run without what it would go on from.

    Raises:
        NotStored: the folder holds no result that this version reads; the message says what to do.
    """
    from retrodict.findings.stored import load as read

    return Result(*read(Path(folder)))


@shown_in_notebooks
def replay(path: str | Path, *, progress: Progress | None = None) -> Reproduction:
    """Verify an archive, run it anew as it was asked for, and compare every number.

    Args:
        path: of an archive, from `Result.archive`.
        progress: as of `reconstruct`.

    Returns:
        Which numbers came out the same, and which versions differ.

    Raises:
        NotArchived: the file is no archive, or was altered; the message names what was.
        SceneError: this version does not read the scene.
        Unanswerable, Interrupted: as of `reconstruct`.
    """
    from retrodict.findings.reproduction import compare
    from retrodict.findings.stored import draws_of
    from retrodict.report.archive import read_archive
    from retrodict.report.result_archive import recorded_in

    archive = read_archive(Path(path))
    recorded = recorded_in(archive, str(path))
    result = reconstruct(recorded.scene, **recorded.asked, progress=progress)
    draws = draws_of(recorded.draws)
    return compare(archive.link, recorded.summary, draws, result.findings, result.idata)


@shown_in_notebooks
def reconstruct(
    scene: Scene,
    *,
    model: str = AUTO,
    method: str = AUTO,
    chains: int = _CHAINS,
    draws: int | None = None,
    warmup: int = 150,
    seed: int = 0,
    progress: Progress | None = None,
    resume: Path | None = None,
) -> Result:
    """The joint posterior of B's approach, e, e_m and mu.

    Args:
        scene: what was measured, from `load_scene`.
        model: a rung's name; "auto" for the one that the ladder chooses among those that the
            question and the evidence allow, or the fullest of them where it chooses none.
        method: nuts (the reference), importance, smc, laplace, monte-carlo or linear; "auto" for nuts,
            and for smc where some wheel rolls, whose run-outs bend too much for its derivatives. Where
            nuts or importance fails, the other stands in, and then smc; a note says so.
        chains: of draws; independent replicates where a method has no chains.
        draws: kept of each; None for as many as the method takes by default.
        warmup: iterations before them, where a method has any.
        seed: of every random number; same seed, same machine, same numbers.
        progress: called with (stage, done, of all) as the work goes on, the stage after the name of
            the model; None shows it in a notebook, and nothing elsewhere.
        resume: `chains.npz` of a run that was interrupted, to go on with.

    Returns:
        The result.

    Raises:
        ValueError: no model or method has that name, or `resume` is of another run.
        Unanswerable: the scene has no posterior that could be sampled; the message says why.
        Interrupted: stopped before any draw was kept.
    """
    asked: dict[str, int | str | None] = {"model": model, "method": method, "chains": chains}
    asked |= {"draws": draws, "warmup": warmup, "seed": seed}
    if resume is not None:
        checkpoint.read(resume)  # what is damaged is refused before the work
    comparison, search = None, ModeSearch(scene, seed)
    # what the ladder draws of scenes in which wheels roll takes longest, and is kept
    kept: dict[str, Outcome] = {}
    keeps = False
    if method == AUTO:
        method = method_for(scene) if scene.rolling else "nuts"
        keeps = bool(scene.rolling) and (chains, draws) == (_CHAINS, None)
    if model == AUTO:
        rungs = allowed(scene)
        if len(rungs) > 1:
            keep = kept.__setitem__ if keeps else None
            comparison = ladder(scene, seed=seed, progress=progress, search=search, keep=keep)
            if not comparison.complete:
                raise Interrupted("stopped before a model was chosen")
        model = (comparison and comparison.choice) or rungs[-1]
        if model in kept:
            return Result(replace(kept[model], asked=asked), comparison)
    outcome = _reconstruct(
        scene,
        model=model,
        method=method,
        chains=chains,
        draws=draws,
        warmup=warmup,
        seed=seed,
        progress=prefixed(progress or silent, model),
        resume=resume,
        search=search,
        asked=asked,
    )
    return Result(outcome, comparison)


@shown_in_notebooks
def calibrate(
    scene: Scene | None = None,
    *,
    model: str = DEFAULT_RUNG,
    method: str = "importance",
    simulations: int = 1000,
    seed: int = 0,
    out: str | Path | None = None,
    processes: int | None = None,
    progress: Progress | None = None,
) -> Calibration:
    """Whether a model and a method can be relied on: simulated crashes, and where the truth lies.

    Several processes are started; a script calls this under `if __name__ == "__main__":`.

    Args:
        scene: the design, of which the inputs and all errors count; None for the one of the package.
        model: a rung's name.
        method: importance, nuts or smc.
        simulations: how many.
        seed: of every random number.
        out: folder for calibration.csv, .json, .png and .svg; a run goes on with the .csv that is
            there. None writes nothing.
        processes: to run side by side; None for one a core.
        progress: as of `reconstruct`, without a model's name.

    Returns:
        The ranks; `retrodict.studies.uniformity.uniformity` judges them. When interrupted, those of
        the simulations that were finished.

    Raises:
        ValueError: no model or method has that name, the scene cannot be simulated, or the file in
            `out` is of another calibration.
        OSError: a file could not be written.
    """
    from retrodict.report.calibration import read_ranks, write_calibration, write_ranks

    scene = scene or _calibration.design()
    asked = Calibration(scene, model, method, seed, simulations)
    folder = None if out is None else Path(out)
    found = _calibration.calibrate(
        scene,
        model=model,
        method=method,
        simulations=simulations,
        seed=seed,
        known=read_ranks(asked, folder) if folder else (),
        processes=processes,
        progress=progress,
        keep=partial(write_ranks, directory=folder) if folder else None,
    )
    if folder:
        write_calibration(found, folder)
    return found


@shown_in_notebooks
def validate(
    folder: str | Path = "examples",
    *,
    model: str = AUTO,
    method: str = "nuts",
    units: Units = "si",
    out: str | Path | None = None,
    progress: Progress | None = None,
) -> Validation:
    """How reconstructions of staged collisions compare with what was measured.

    Args:
        folder: holds the cases, each a folder with scene.toml and truth.toml.
        model: a rung's name, or auto for the one that the ladder chooses.
        method: as of `reconstruct`.
        units: of the table and the chart, "si" or "us".
        out: folder for validation.md, .csv, .json, .png and .svg. None writes nothing.
        progress: as of `reconstruct`, with the name of the case first.

    Returns:
        The scores; when interrupted, those of the cases that were finished.

    Raises:
        ValueError: no model or method has that name, or there is no case in the folder.
        OSError: a file could not be written.
    """

    def run(scene: Scene, progress: Progress) -> Outcome:
        return reconstruct(scene, model=model, method=method, progress=progress).outcome

    def write(found: Validation) -> None:
        if out is not None:
            from retrodict.report.validation import write_validation

            write_validation(found, Path(out), units)

    folders = _validation.cases(Path(folder))
    found = _validation.validate(
        folders, run, model=model, method=method, progress=progress, keep=write
    )
    write(found)
    return found
