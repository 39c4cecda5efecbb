"""The user's home in a notebook: a reconstruction, to look at, save and report."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from retrodict.inference.outcome import Checks, Outcome
from retrodict.notebook import Scene  # with what it shows of itself
from retrodict.scene.asked import read_proposition
from retrodict.scene.quantities import Units
from retrodict.studies.comparison import Ladder

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from retrodict.findings import Findings
    from retrodict.findings.answers import Answered
    from retrodict.findings.differences import Differences
    from retrodict.scene.case import Case

CHAINS = "chains.npz"  # what an interrupted run needs to go on


@dataclass(frozen=True, repr=False)
class Result:
    """A reconstruction: its draws, its checks, its figures and its report.

    Args:
        outcome: outcome of the run.
        ladder: comparison with the other models, where the ladder chose this one; None otherwise.
    """

    outcome: Outcome
    ladder: Ladder | None = None

    @property
    def scene(self) -> Scene:
        """The scene with its measurements."""
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
        """The reported quantities, and what follows from them, in a table.

        Args:
            units: units of the table, "si" or "us".

        Returns:
            One row a quantity, delta-v and the principal direction of force (PDOF) among them, one
            column a statistic; quantities that failed a check of their own, or follow from one that
            did, are NaN, and the column `checks` says so.
        """
        from retrodict.findings.summary import summary_frame

        return summary_frame(self.findings, units)

    def compare(self, other: Result) -> Differences:
        """Comparison with another result, of the same scene or a changed one, by any model.

        Args:
            other: result to compare with.

        Returns:
            The record: `verdict`, a few sentences; `table(units)`, a pandas table of means and standard
            deviations of both, and of the difference, also in standard deviations and in Monte Carlo
            standard errors; `changes()`, a table of the keys of the scene file and of the run that
            differ. A notebook shows all.

        Raises:
            NothingInCommon: there is no quantity of which both have numbers.
        """
        from retrodict.findings.differences import differences

        return differences(self.findings, other.findings)

    def probability(self, proposition: str) -> Answered:
        """How probable a proposition about a reported quantity is, given the evidence.

        Args:
            proposition: text such as "speed_b > 45 mph" or "40 mph < speed_b < 50 mph", in any unit that
                a scene file may have.

        Returns:
            The answer: `sentences` in words, and `numbers` with `value` and Monte Carlo `error`; no
            numbers where the result is withheld.

        Raises:
            ValueError: the text is no such proposition; the message says what to write instead.
        """
        from retrodict.findings.questions import probability_of

        found = self.findings
        quantities = found.quantities | found.derived
        return probability_of(self.outcome, quantities, read_proposition(proposition))

    def findings_for(self, case: Case | None) -> Findings:
        """The findings, with the answers to a case's questions after those to the scene's.

        Args:
            case: case with further questions, from `load_case`; None for no case.

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
            path: path of the file, replaced whole: .html, .pdf or .docx.
            units: units that come first, "si" or "us"; None for those of the case, or else SI.
            case: case with the expert's statements, or the path of a case file; None for no case.

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
        """Write the result and all that it came from as one file, which `replay` verifies and runs anew.

        Args:
            path: path of the file, replaced whole; by custom it ends in .retrodict.zip.
            case: path of a case file; its attachments are recorded by their SHA-256.

        Returns:
            The path.

        Raises:
            SceneError: the case file cannot be used.
            OSError: the file could not be written.
        """
        from retrodict.report.result_archive import archived
        from retrodict.storage.archive import archive_bytes
        from retrodict.storage.files import write_whole

        files = archived(self.findings, self.outcome, self.ladder, Path(case) if case else None)
        return write_whole(Path(path), archive_bytes(files))

    def export(
        self,
        directory: str | Path,
        formats: Iterable[str] = (),
        *,
        draws: Iterable[str | int] = (),
        rate: float = 30.0,
        before: float = 1.0,
        units: Units = "si",
    ) -> list[Path]:
        """Write the result for other programs: motions, drawings, tables and draws.

        Args:
            directory: folder for the files, made where missing; files of the same names in it are
                replaced together.
            formats: names of formats: motion, dxf, svg, tables, netcdf or parquet; empty for all.
            draws: draws whose motion is written: "median" or a percentage of the sought speed, or the
                number of a draw whose motion is recorded; empty for the median, 5% and 95%. Drawings
                show the first.
            rate: frame rate of motions, frames a second.
            before: time before the impact at which motions begin, s.
            units: units of tables, "si" or "us".

        Returns:
            The files.

        Raises:
            NotExported: a format, the rate or `before` cannot be used.
            NoMotion: there is no such draw, or no motion is recorded.
            MissingLibrary: dxf or parquet need a library that is not installed.
            OSError: something could not be written; then nothing in the directory has changed.
        """
        from retrodict.report.export import DRAWS, Asked, write_export

        asked = Asked(tuple(draws) or DRAWS, rate, before, units)
        return write_export(self.findings, self.outcome, Path(directory), formats, asked)

    def save(self, directory: str | Path, units: Units = "si") -> Path:
        """Write the result: `load_result` reads it again.

        The files are posterior.nc, run.json, scene.toml, report.html, figures/*.png,
        figures/scene.svg, summary.json, and chains.npz if the run was interrupted. The summary comes
        last and has the digests of the others, so that a mixture of two runs shows.

        Args:
            directory: folder for the files, made where missing; files of the same names in it are
                replaced, once all of the new ones are written, and others are left alone. Where it
                holds the answer of a finished run, an interrupted run writes chains.npz only.
            units: units of the report and the figures, "si" or "us".

        Returns:
            The directory.

        Raises:
            OSError: something could not be written; then nothing in the directory has changed.
        """
        from retrodict.findings.stored import stored
        from retrodict.findings.summary import SUMMARY, holds_answer, summary_json
        from retrodict.report.document import FORMATS, document_of
        from retrodict.report.figures.registry import images, svgs
        from retrodict.storage.files import write_together

        directory = Path(directory)
        chains = {CHAINS: self.outcome.unfinished} if self.outcome.unfinished else {}
        if not self.outcome.complete and holds_answer(directory):
            write_together(directory, chains)
            return directory
        drawn = images(self.findings, self.outcome, units)
        document = document_of(self.findings, self.outcome, units, drawn=drawn)
        files = {
            **stored(self.outcome, self.ladder),
            "scene.toml": self.findings.scene_text.text.encode(),
            "report.html": FORMATS["html"](document),
            **{f"figures/{name}.png": image for name, image in drawn.items()},
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
        from retrodict.report.figures.registry import ASKED, FIGURES

        return (FIGURES | ASKED)[name].draw(self.findings, self.outcome, units)

    def __repr__(self) -> str:
        verdict = "passed" if self.checks.passed else "FAILED"
        model, seed = self.outcome.description.name, self.outcome.seed
        return f"<Result of {self.scene.name!r}: {model}, seed {seed}, checks {verdict}>"

    def _repr_html_(self) -> str:
        from retrodict.report.fragments import findings_html

        return findings_html(self.findings)


def load_result(path: str | Path) -> Result:
    """The result that was saved in a folder or an archive.

    Args:
        path: path of the folder that `Result.save`, or `retrodict reconstruct`, wrote to, or of the
            archive that `Result.archive`, or `retrodict archive`, wrote.

    Returns:
        The result, as it was, but without the chains that an interrupted run would go on from.

    Raises:
        NotStored: there is no result that this version reads; the message says what to do.
        NotArchived: the file is no archive, or was altered.

    Examples:
        >>> import retrodict as rd
        >>> scene = rd.load_scene("examples/brach-1977/scene.toml")
        >>> result = rd.reconstruct(scene, model="momentum+slide", method="importance")
        >>> path = result.archive("saved.retrodict.zip")
        >>> rd.load_result(path).checks.passed
        True
    """
    from retrodict.findings.stored import load as from_folder
    from retrodict.findings.stored import of_files

    path = Path(path)
    if not path.is_file():
        return Result(*from_folder(path))
    from retrodict.storage.archive import read_archive

    return Result(*of_files(read_archive(path).files, path))
