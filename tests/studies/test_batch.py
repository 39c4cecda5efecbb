"""A batch: each scene as if it were alone, each once, and what stops one stops no other."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from retrodict.models import RUNGS

import retrodict as rd
from retrodict.inference.density.together import Calls
from retrodict.report import batch as files
from retrodict.report.libraries import MissingLibrary
from retrodict.scene.write import scene_toml
from retrodict.storage import rows
from retrodict.studies import batch as study
from retrodict.studies import calibration
from retrodict.studies.batch import Answered, Asked, Entry, answer, answers
from retrodict.studies.engine import Engine, WorkerDied
from retrodict.studies.short import STATISTICS

ROOT = Path(__file__).parents[2]
QUICK = "momentum+slide"
RETRODICT = Path(sys.executable).with_name("retrodict")


def crashes(count: int) -> list[rd.Scene]:
    """Crashes of one structure, simulated from the quickest rung, and measured."""
    design = calibration.design()
    structure, data = RUNGS[QUICK].of_scene(design)
    programs = calibration.programs_for(structure)
    _, quantities = calibration._truths(programs, data, np.random.default_rng(0))
    rng = np.random.default_rng(1)
    made = []
    for i in range(count):
        known = {k: v[i % len(v)] for k, v in quantities.items()}
        crash = calibration._measured(design, structure, known, rng)
        made.append(replace(crash, name=f"crash-{i}"))
    return made


def written(scenes: list[rd.Scene], folder: Path) -> list[Path]:
    """A scene file of each; of every tenth, from the fifth on, a broken one."""
    folder.mkdir()
    paths = []
    for i, scene in enumerate(scenes):
        paths.append(folder / f"{i:03}.toml")
        text = scene_toml(scene)
        paths[-1].write_text(text.replace("mass", "mess", 1) if i % 10 == 5 else text, "utf-8")
    return paths


def made_up(scene: rd.Scene, model: str, seed: int) -> Answered:
    numbers = dict.fromkeys(STATISTICS, scene.approach["a"].speed.value)
    return Answered(model, "importance", numbers={"speed_b": numbers})


@pytest.mark.slow
def test_an_answer_hangs_on_its_scene_alone() -> None:
    one, other = crashes(2)
    first = answer(one, QUICK, 0)
    assert first.method == "importance"
    assert not first.reason
    assert set(first.numbers["speed_b"]) == set(STATISTICS)
    answer(other, QUICK, 0)
    assert answer(one, QUICK, 0) == first
    assert answer(one, QUICK, 1) != first


@pytest.mark.slow
def test_a_gpus_scenes_are_answered_together_and_what_is_left_one_by_one(monkeypatch) -> None:
    """The way of a GPU, on the processor: points of all, more points, then by `answer`."""
    scenes = {str(i): scene for i, scene in enumerate(crashes(3))}
    tried: list[tuple[str, int]] = []
    by_points = study._by_points

    def fails_at_times(scene: rd.Scene, model: str, seed: int, times: int) -> Answered | None:
        tried.append((scene.name, times))
        if scene is scenes["1"]:
            raise ArithmeticError("no")
        return None if scene is scenes["2"] and times == 1 else by_points(scene, model, seed, times)

    monkeypatch.setattr(study, "_by_points", fails_at_times)
    monkeypatch.setattr(study, "_ready", lambda _: None)
    monkeypatch.setattr(study, "Calls", partial(Calls, 256, 256))
    monkeypatch.setattr(study, "answer", made_up)
    found = study._answer_all(Asked(QUICK, device="gpu"), tuple(scenes.items()))
    assert sorted(tried) == [
        ("crash-0", 1),
        ("crash-1", 1),
        ("crash-1", 4),
        ("crash-2", 1),
        ("crash-2", 4),
    ]
    monkeypatch.undo()
    alone = answer(scenes["0"], QUICK, 0)
    for name, value in alone.numbers["speed_b"].items():
        assert found[0].numbers["speed_b"][name] == pytest.approx(value, rel=1e-6), name
    assert found[1] == made_up(scenes["1"], QUICK, 0)
    assert found[2].method == "importance"


def test_one_scene_in_ten_is_broken_and_the_others_do_not_notice(tmp_path, monkeypatch) -> None:
    def fragile(scene: rd.Scene, model: str, seed: int) -> Answered:
        if scene.title == "breaks":
            raise TypeError("of a kind\nthat nobody knew")
        return made_up(scene, model, seed)

    design = calibration.design()
    scenes = [replace(design, text="", title="breaks" if i == 7 else "=1+1") for i in range(20)]
    monkeypatch.setattr(study, "_by_points", fragile)
    paths = [*written(scenes, tmp_path / "scenes"), tmp_path / "missing.toml"]
    table = rd.batch(paths, model=QUICK, workers=1, out=tmp_path / "out", units="us")
    assert list(table["scene"]) == [str(path) for path in paths]
    bad = {5: "unusable: ", 15: "unusable: ", 20: "unusable: no such file"}
    bad[7] = "unexpected: TypeError: of a kind"
    for i, row in table.iterrows():
        assert row["checks"].startswith(bad.get(i, "passed"))
        assert np.isnan(row["speed_b_mean"]) == (i in bad)
    assert "vehicles.A.mess" in table["checks"][5]
    assert table["speed_b_mean"][0] == pytest.approx(18 / 0.44704)
    said = "17 of 21 scenes answered: 17 importance. Without numbers: 3 unusable, 1 unexpected."
    assert files.in_words(table) == said
    lines = (tmp_path / "out" / "table.csv").read_text("utf-8").splitlines()
    assert len(lines) == 1 + len(paths)
    assert "speed_b_mean [mph]" in lines[0]


def test_a_table_is_the_same_as_csv_and_as_parquet(tmp_path: Path) -> None:
    import pandas as pd

    found = made_up(calibration.design(), QUICK, 0)
    bad = Answered(reason="=cmd|' /C calc'!A0")
    table = files.table_of(["a.toml", "-b.toml"], [found, bad])
    files.write_table(table, tmp_path)
    csv = pd.read_csv(tmp_path / "table.csv")
    parquet = pd.read_parquet(tmp_path / "table.parquet")
    assert list(csv.columns) == list(parquet.columns)
    assert csv["speed_b_mean [m/s]"].equals(parquet["speed_b_mean [m/s]"])
    assert list(csv["scene"]) == ["a.toml", "'-b.toml"]  # no formula for a spreadsheet
    assert csv["checks"][1] == f"'{parquet['checks'][1]}"


def test_answers_are_read_as_they_were_kept(tmp_path: Path) -> None:
    numbers = dict.fromkeys(STATISTICS, 1 / 3) | {"mcse_mean": np.nan}
    kept = {"k": Answered("m", "smc", "", ("a flag",), {"e": numbers}), "l": Answered(reason="r")}
    files.write_answers(kept, tmp_path)
    (tmp_path / "rows" / "damaged.jsonl").write_text('{"key": "n", "model": "m"', "utf-8")
    found = files.read_answers(tmp_path)
    assert repr(found) == repr(kept)  # NaN is not equal to itself


def test_what_was_answered_is_not_asked_again_but_what_changed_is(tmp_path, monkeypatch) -> None:
    asked = []

    def noted(scene: rd.Scene, model: str, seed: int) -> Answered:
        asked.append(scene.title)
        return made_up(scene, model, seed)

    monkeypatch.setattr(study, "_by_points", noted)
    design = calibration.design()
    scenes = [replace(design, text="", title=title) for title in "abc"]
    for changed, again, seed in (({}, "abc", 0), ({}, "", 0), ({1: "d"}, "d", 0), ({}, "adc", 1)):
        for i, title in changed.items():
            scenes[i] = replace(design, text="", title=title)
        rd.batch(scenes, model=QUICK, seed=seed, workers=1, out=tmp_path)
        assert sorted(asked) == sorted(again)
        asked.clear()
    table = rd.batch([scenes[2], scenes[0], scenes[2]], model=QUICK, workers=1, out=tmp_path)
    assert len(table) == 3
    assert not asked


def test_ctrl_c_keeps_what_is_done_and_writes_no_table(tmp_path, monkeypatch) -> None:
    def stopped(scene: rd.Scene, model: str, seed: int) -> Answered:
        if scene.title == "b":
            raise KeyboardInterrupt
        return made_up(scene, model, seed)

    monkeypatch.setattr(study, "_by_points", stopped)
    design = calibration.design()
    scenes = [replace(design, text="", title=title) for title in "ab"]
    assert len(rd.batch(scenes, model=QUICK, workers=1, out=tmp_path)) == 1
    assert len(files.read_answers(tmp_path)) == 1
    assert not (tmp_path / "table.csv").exists()


class Mortal(Engine):
    """An engine that loses every worker which is given a scene called fatal."""

    def __init__(self) -> None:
        super().__init__(None)
        self.sizes = []

    def each(self, job, items, more=lambda item, result: ()):
        def doomed(scenes):
            if not isinstance(scenes[0][1], rd.Scene):
                return job(scenes)
            self.sizes.append(len(scenes))
            return WorkerDied("killed") if "fatal" in [s.title for _, s in scenes] else job(scenes)

        return super().each(doomed, items, more)


def test_the_scene_that_ends_its_worker_has_a_row_and_its_neighbours_have_answers(
    monkeypatch,
) -> None:
    monkeypatch.setattr(study, "_by_points", made_up)
    design = calibration.design()
    titles = [*"abcdefg", "fatal", *"hijklmn"]
    entries = [Entry.of(replace(design, text="", title=title)) for title in titles]
    engine = Mortal()
    found = answers(entries, Asked(QUICK), engine)
    # the first alone; then four at a time, of which those with it come singly
    assert engine.sizes == [1, 4, 4, 4, 2, *[1] * 4]
    reasons = [each.reason for each in found if each]
    assert reasons == ["unexpected: killed" if title == "fatal" else "" for title in titles]


def test_a_second_command_in_a_folder_is_refused(tmp_path: Path) -> None:
    with (
        rows.locked(tmp_path),
        pytest.raises(rows.InUse, match="another command answers scenes there"),
    ):
        rd.batch([calibration.design()], model=QUICK, workers=1, out=tmp_path)


def test_what_is_not_installed_is_named_with_the_command(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingLibrary, match=r"pip install 'distributed"):
        rd.batch([], workers=2)


def command(scenes: Path, out: Path, *arguments: object) -> list[str]:
    asked = ["batch", f"{scenes}/*.toml", "--out", out, "--model", QUICK, *arguments]
    return [str(RETRODICT), *map(str, asked)]


def killed_until_done(of: list[str], out: Path, kills: int, rng: np.random.Generator) -> None:
    """Run a command, and kill it or one of its workers at random moments, so many times; then let be."""
    import psutil

    for _ in range(kills):
        before = len(list(out.glob("rows/*")))
        with subprocess.Popen(of, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as run:
            while run.poll() is None and len(list(out.glob("rows/*"))) == before:
                time.sleep(0.05)
            time.sleep(rng.uniform(0, 2))
            workers = psutil.Process(run.pid).children() if run.poll() is None else []
            if len(workers) > 1 and rng.random() < 0.5:
                os.kill(workers[rng.integers(len(workers))].pid, signal.SIGKILL)
                time.sleep(rng.uniform(0, 5))
            run.kill()
    done = subprocess.run(of, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("count", "workers", "kills"),
    [(4, 1, 1), pytest.param(40, 2, 5, marks=pytest.mark.slow)],
)
def test_a_table_is_the_same_whatever_is_killed(tmp_path: Path, count, workers, kills) -> None:
    written(crashes(count), tmp_path / "scenes")
    of = command(tmp_path / "scenes", tmp_path / "killed", "--workers", workers)
    killed_until_done(of, tmp_path / "killed", kills, np.random.default_rng(0))
    undisturbed = command(tmp_path / "scenes", tmp_path / "out", "--workers", 1)
    subprocess.run(undisturbed, check=True, capture_output=True)
    tables = [(tmp_path / name / "table.csv").read_text("utf-8") for name in ("killed", "out")]
    assert len(tables[0].splitlines()) == 1 + count
    assert tables[0] == tables[1]


@pytest.mark.slow
def test_a_cluster_in_other_processes_gives_the_same_table(tmp_path: Path) -> None:
    """By the commands of docs/batch.md, on another port than theirs."""
    lines = (ROOT / "docs" / "batch.md").read_text("utf-8").splitlines()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    asked = [line.replace("8786", str(port)).split() for line in lines if line[:5] == "dask "]
    assert [words[1] for words in asked] == ["scheduler", "worker", "worker"]
    asked[0] += ["--port", str(port)]
    written(crashes(12), tmp_path / "scenes")
    with ExitStack() as stack:
        for _, *arguments in asked:
            of = [Path(sys.executable).with_name("dask"), *arguments]
            running = subprocess.Popen(of, cwd=tmp_path, stderr=subprocess.DEVNULL)
            stack.callback(running.wait, 60)
            stack.callback(running.terminate)
        time.sleep(10)  # the scheduler listens
        tables = []
        for how in (["--scheduler", f"tcp://127.0.0.1:{port}"], ["--workers", 1]):
            out = tmp_path / how[0]
            done = subprocess.run(
                command(tmp_path / "scenes", out, *how),
                check=False,
                capture_output=True,
                text=True,
            )
            assert done.returncode == 0, done.stderr
            tables.append((out / "table.csv").read_text("utf-8"))
    assert tables[0] == tables[1]
