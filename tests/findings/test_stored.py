"""A result that was saved is read as it was, and nothing of another run with it."""

import dataclasses
import json
import math

import pytest

import retrodict
from retrodict import findings
from retrodict.findings.stored import NotStored, load, stored
from retrodict.findings.summary import SUMMARY, summarise, summary_json
from retrodict.report.figures import registry as figures
from retrodict.result import Result
from retrodict.storage.archive import NotArchived, archive_bytes
from tests.studies.made_up import ladder_of, step


@pytest.fixture(autouse=True)
def _no_figures(monkeypatch):
    monkeypatch.setattr(figures, "FIGURES", {})


@pytest.mark.parametrize(
    "which",
    [
        "outcome",
        *(pytest.param(n, marks=pytest.mark.slow) for n in ("sparse", "rolled", "failing")),
    ],
)
def test_what_is_loaded_is_what_was_saved(which, request, tmp_path):
    """Every number of the findings, and every field of the outcome but its draws, is the same."""
    outcome = request.getfixturevalue(which)
    Result(outcome).save(tmp_path / "run")
    again = retrodict.load_result(tmp_path / "run")
    assert again.ladder is None
    for field in dataclasses.fields(outcome):
        if field.name != "idata":
            assert getattr(again.outcome, field.name) == getattr(outcome, field.name), field.name
    assert set(again.idata.children) == set(outcome.idata.children)
    assert summarise(again.findings) == summarise(findings.compute(outcome))


@pytest.mark.slow
def test_an_archive_is_read_as_its_folder_is(outcome, tmp_path):
    result = Result(outcome)
    again = retrodict.load_result(result.archive(tmp_path / "x.retrodict.zip"))
    assert summarise(again.findings) == summarise(result.findings)
    (tmp_path / "posterior.nc").write_bytes(b"not an archive")
    with pytest.raises(NotArchived, match="no archive that can be read"):
        retrodict.load_result(tmp_path / "posterior.nc")
    (tmp_path / "other.zip").write_bytes(archive_bytes({"about.json": b"{}"}))
    with pytest.raises(NotStored, match=r"posterior\.nc, run\.json is missing"):
        retrodict.load_result(tmp_path / "other.zip")


@pytest.mark.slow
def test_the_ladder_and_what_is_not_finite_are_kept(outcome, tmp_path):
    ladder = ladder_of(step("low", 19.0), step("full", math.nan))
    checks = dataclasses.replace(outcome.checks, max_rhat=math.inf)
    Result(dataclasses.replace(outcome, checks=checks), ladder).save(tmp_path)
    again = retrodict.load_result(tmp_path)
    assert math.isinf(again.checks.max_rhat)
    assert again.ladder.steps[0] == ladder.steps[0]
    assert math.isnan(again.ladder.steps[1].answers["speed_b"].median)
    json.loads((tmp_path / "run.json").read_text("utf-8"), parse_constant=pytest.fail)


def test_a_folder_without_a_result_is_refused_in_a_line(outcome, tmp_path):
    with pytest.raises(NotStored, match="no such folder"):
        load(tmp_path / "none")
    with pytest.raises(NotStored, match=r"summary\.json is missing"):
        load(tmp_path)
    found = findings.compute(outcome)
    (tmp_path / SUMMARY).write_bytes(summary_json(found, {}))
    with pytest.raises(NotStored, match="earlier version"):
        load(tmp_path)
    files = stored(outcome)
    files[SUMMARY] = summary_json(found, files)
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    assert load(tmp_path)[0].seed == outcome.seed
    (tmp_path / "run.json").write_bytes(files["run.json"].replace(b"saloon A", b"saloon C"))
    with pytest.raises(NotStored, match=r"not of the run that summary\.json is of: run\.json"):
        load(tmp_path)
