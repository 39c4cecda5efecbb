"""Two results beside each other, as a document and by the command."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from retrodict.cli import app
from retrodict.findings import compute
from retrodict.findings.differences import differences
from retrodict.report.blocks import Picture, Table
from retrodict.report.comparison import compared, steps_table
from retrodict.result import Result
from retrodict.studies.attribution import Step
from tests.findings.test_differences import with_draws
from tests.report.conftest import make_outcome

STEPS = (
    Step("", "", "", 19.0, 0.9),
    Step("impact.contact_line", "0 ± 4 deg", "5 ± 4 deg", 19.2, 0.9),
    Step("vehicles.A.mass", "1500 kg", "1600 kg", 18.1, 0.8),
    Step("vehicles.A.grip", "1 ± 0.1", "", why="withheld: checks of its draws failed"),
)


def test_steps_come_in_the_order_of_what_they_move() -> None:
    rows = steps_table(STEPS, "speed_b").rows
    assert [row[0] for row in rows] == [
        "as in the first", "vehicles.A.mass", "impact.contact_line", "vehicles.A.grip"
    ]  # fmt: skip
    assert rows[1] == ("vehicles.A.mass", "1500 kg", "1600 kg", "18.1 ± 0.8", "−0.90")
    assert rows[3][3].startswith("withheld")
    in_mph = steps_table(STEPS, "speed_b", "us")
    assert in_mph.header[3] == "impact speed of B, mph"
    assert in_mph.rows[1][4] == "−2.01"


def test_a_document_has_both_answers_the_verdict_and_a_figure() -> None:
    outcome = make_outcome()
    other = with_draws(outcome, speed_b=outcome.idata["posterior"]["speed_b"] + 1)
    one, two = compute(outcome), compute(other)
    document = compared(differences(one, two), (one, outcome), (two, other), STEPS, "speed_b")
    verdict, first, second, picture = document.first
    assert "The answers differ" in verdict.text
    assert first.text == f"First: {one.answers['si']}"
    assert second.text == f"Second: {two.answers['si']}"
    assert isinstance(picture, Picture)
    assert picture.image.startswith(b"\x89PNG")
    assert [each.number for each in document.sections] == ["1", "2", "3"]
    (table,) = document.sections[0].blocks
    assert isinstance(table, Table)
    assert table.rows[0][0] == "impact speed of B, m/s"


@pytest.mark.slow
def test_the_command_prints_and_writes(tmp_path: Path) -> None:
    for name in ("one", "other"):
        Result(make_outcome()).save(tmp_path / name)
    arguments = ["compare", str(tmp_path / "one"), str(tmp_path / "other"), "--quiet"]
    done = CliRunner().invoke(
        app, [*arguments, "--format", "html", "--out", str(tmp_path / "both")]
    )
    assert done.exit_code == 0, done.output
    page = (tmp_path / "both" / "comparison.html").read_text("utf-8")
    assert "The answers agree within Monte Carlo error." in page
    missing = CliRunner().invoke(app, ["compare", str(tmp_path / "one"), str(tmp_path / "none")])
    assert missing.exit_code == 2
