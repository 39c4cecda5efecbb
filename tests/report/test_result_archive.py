"""The archive of a result holds what it came from, and only that is run anew."""

import json
from dataclasses import replace

import pytest

from retrodict import api
from retrodict.options import RunOptions
from retrodict.report.result_archive import recorded_in
from retrodict.result import Result
from retrodict.scene import SceneError
from retrodict.storage.archive import NotArchived, archive_bytes, read_archive

ASKED = {"model": "auto", "method": "auto", "chains": 4, "draws": None, "warmup": 150, "seed": 20}


@pytest.fixture(scope="module")
def result(outcome):
    return Result(replace(outcome, asked=RunOptions(**ASKED)))


@pytest.fixture(scope="module")
def path(result, tmp_path_factory):
    return result.archive(tmp_path_factory.mktemp("archive") / "one.retrodict.zip")


def changed(path, tmp_path, name, content):
    """An archive in order, but of other content."""
    files = read_archive(path).files | {name: content}
    other = tmp_path / "other.zip"
    other.write_bytes(archive_bytes(files))
    return other


def test_a_replay_runs_the_recorded_scene_as_it_was_asked_for(path, result, monkeypatch):
    ran = []

    def run(scene, **options):
        ran.append((scene, options))
        return result

    monkeypatch.setattr(api, "reconstruct", run)
    found = api.replay(path)
    assert found.reproduced
    assert found.link == read_archive(path).link
    ((scene, options),) = ran
    assert (scene.name, scene.title) == (result.scene.name, result.scene.title)
    assert scene.vehicles["a"].mass == result.scene.vehicles["a"].mass
    assert {name: options[name] for name in ASKED} == ASKED


@pytest.mark.slow
def test_a_run_with_a_term_of_the_users_own_is_replayed_with_it_alone(
    result, tmp_path, monkeypatch
):
    """An archive names what is the user's own; without it, or with more, the run is another one."""
    extra = {"witness": lambda q: -(((q["speed_b"] - 20.0) / 3.0) ** 2) / 2}
    own = Result(replace(result.outcome, scene=replace(result.scene, extra=extra)))
    path = own.archive(tmp_path / "own.zip")
    assert json.loads(read_archive(path).files["about.json"])["own"] == [
        "the likelihood term witness"
    ]
    ran = []
    monkeypatch.setattr(api, "reconstruct", lambda scene, **_: ran.append(scene) or own)
    for others in ({}, {"extra": {"another": extra["witness"]}}):
        with pytest.raises(ValueError, match="the run had of the user's own the likelihood term w"):
            api.replay(path, **others)
    assert not ran
    api.replay(path, extra=extra)
    assert ran[0].extra == extra


def test_an_archive_is_the_same_twice(path, result, tmp_path):
    again = result.archive(tmp_path / "again.zip")
    assert again.read_bytes() == path.read_bytes()


def test_an_archive_says_what_it_is_of(path, result):
    about = json.loads(read_archive(path).files["about.json"])
    assert about["versions"] == result.outcome.versions
    assert about["asked"] == ASKED
    assert (about["title"], about["seed"], about["evidence"]) == (result.scene.title, 20, [])


def test_attachments_of_a_case_are_recorded_by_their_hash(result, tmp_path):
    (tmp_path / "photo.jpg").write_bytes(b"photo")
    case = tmp_path / "case.toml"
    case.write_text('schema = 1\nattachments = [{ file = "photo.jpg" }]\n')
    files = read_archive(result.archive(tmp_path / "one.zip", case)).files
    assert files["case.toml"] == case.read_bytes()
    (evidence,) = json.loads(files["about.json"])["evidence"]
    assert evidence["file"] == "photo.jpg"
    # SHA-256 of "photo"
    assert evidence["sha256"].startswith("55c64d0fcd6f9d5f")
    case.write_text('schema = 1\nattachments = [{ file = "../secret" }]\n')
    with pytest.raises(SceneError):
        result.archive(tmp_path / "two.zip", case)
    assert not (tmp_path / "two.zip").exists()


@pytest.mark.parametrize(
    "asked",
    [
        {"chains": 10**9},
        {"draws": "many"},
        {"seed": -1},
        {"model": 3},
        {"resume": "/etc/passwd"},
        {},
    ],
)
def test_what_no_run_was_asked_for_is_not_run(path, tmp_path, asked):
    about = json.loads(read_archive(path).files["about.json"])
    about["asked"] = about["asked"] | asked if asked else None
    other = changed(path, tmp_path, "about.json", json.dumps(about).encode())
    with pytest.raises(NotArchived, match="not the archive of a result"):
        recorded_in(read_archive(other), "other.zip")


def test_an_archive_of_something_else_is_refused(path, tmp_path):
    (tmp_path / "none.zip").write_bytes(archive_bytes({"about.json": b"{}"}))
    with pytest.raises(NotArchived, match=r"none\.zip: not the archive of a result"):
        api.replay(tmp_path / "none.zip")
    with pytest.raises(SceneError):
        api.replay(changed(path, tmp_path, "scene.toml", b"title = 3"))
