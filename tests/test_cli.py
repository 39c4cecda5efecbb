"""The commands as a user runs them, in processes of their own."""

import hashlib
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import arviz
import pytest
from typer.testing import CliRunner

from retrodict.cli import app
from retrodict.cli.options import MethodChoice
from retrodict.inference.samplers import METHODS
from retrodict.report import export
from retrodict.report.figures import registry as figures
from retrodict.result import Result
from tests.report.conftest import make_outcome

ROOT = Path(__file__).parents[1]
SCENE = ROOT / "examples" / "brach-1977" / "scene.toml"
RETRODICT = Path(sys.executable).with_name("retrodict")


# JAX in this process has set how much XLA says: a command sets that itself
ENVIRONMENT = {k: v for k, v in os.environ.items() if k != "TF_CPP_MIN_LOG_LEVEL"}
ENVIRONMENT |= {"COLUMNS": "160", "TERM": "dumb"}


def run(*arguments: object, folder: Path = ROOT) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(RETRODICT), *map(str, arguments)],
        capture_output=True, text=True, cwd=folder, env=ENVIRONMENT, check=False,
    )  # fmt: skip


def reasons(done: subprocess.CompletedProcess[str]) -> list[str]:
    """Lines on standard error beside those of progress."""
    lines = done.stderr.strip().splitlines()
    return [line for line in lines if not line.startswith("retrodict: ")]


def test_version_and_help() -> None:
    assert run("--version").stdout.strip() == "retrodict 0.1.0"
    assert "reconstruct" in run("--help").stdout


def test_a_model_that_is_none_is_refused_with_those_there_are() -> None:
    done = run("reconstruct", SCENE, "--model", "momentum")
    assert done.returncode == 2
    (line,) = reasons(done)
    assert line.startswith("--model momentum: choose auto or one of momentum+slide, ")


def test_a_question_that_does_not_fit_is_one_line_and_status_2() -> None:
    done = run("reconstruct", SCENE, "--exceeds", "speed_b > 45")
    assert done.returncode == 2
    (line,) = reasons(done)
    assert line.startswith('--exceeds "speed_b > 45": no unit; write "45 m/s"')


def test_a_share_out_of_range_is_one_line_and_status_2() -> None:
    done = run("ladder", SCENE, "--share", "nan")
    assert done.returncode == 2
    assert reasons(done) == ["--share nan --factor 1.25: share is above 0, and factor above 1"]


def test_check_accepts_the_example() -> None:
    done = run("check", SCENE)
    assert done.returncode == 0, done.stderr
    assert "fine" in done.stdout
    assert "It asks for impact speed of B, restitution e" in done.stdout
    assert "warning" not in done.stdout


def test_vehicles_are_listed_with_their_sources() -> None:
    done = run("vehicles")
    assert done.returncode == 0, done.stderr
    assert "intermediate car: car with a wheelbase from 265 to 278 cm" in done.stdout
    assert "[1] grade B: " in done.stdout


@pytest.mark.slow
def test_check_draws_a_scene_into_the_file_that_is_named(tmp_path: Path) -> None:
    done = run("check", SCENE, "--plot", tmp_path / "new" / "plan.SVG", "--units", "us")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1].endswith("plan.SVG")
    assert (tmp_path / "new" / "plan.SVG").read_bytes().startswith(b"<?xml")
    for file, said in (("plan.gif", "ends in .png, .svg or .pdf"), ("plan", "ends in .png")):
        done = run("check", SCENE, "--plot", tmp_path / file)
        assert done.returncode == 2
        assert said in done.stderr
        assert not (tmp_path / file).exists()
    folder = run("check", tmp_path, "--plot", tmp_path / "plan.png")
    assert folder.returncode == 2
    assert "name a scene file" in folder.stderr


def test_check_warns_of_an_implausible_value_and_accepts_it(tmp_path: Path) -> None:
    file = tmp_path / "odd.toml"
    line = r"(?m)^contact_line = .*"
    file.write_text(re.sub(line, 'contact_line = "-60 ± 3 deg"', SCENE.read_text()))
    done = run("check", file)
    assert done.returncode == 0, done.stderr
    assert "  warning: impact.contact_line: both centres" in done.stdout


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("mass = { value = 1857, sd = 37", "mass = { value = -1857, sd = 37", "vehicles.A.mass"),
        pytest.param(
            "mass = { value = 1857, sd = 37",
            "mass = { value = 1857, sd = 0",
            "vehicles.A.mass",
            marks=pytest.mark.slow,
        ),
        ('sd = 2, unit = "mph"', 'sd = 2, unit = "kg"', "vehicles.A.approach.speed"),
        pytest.param(
            "[surfaces.road]\nfriction",
            "[surfaces.road]\nfrction",
            "friction",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            'track = { value = 1.54, unit = "m"',
            'track = { value = nan, unit = "m"',
            "vehicles.A.track",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            'track = { value = 1.54, unit = "m"',
            "track = { value = 1.54",
            "vehicles.A.track",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_bad_input_is_one_clear_line_and_status_2(
    tmp_path: Path, old: str, new: str, words: str
) -> None:
    text = SCENE.read_text()
    assert old in text
    bad = tmp_path / "bad.toml"
    bad.write_text(text.replace(old, new, 1))
    for command in ("check", "reconstruct"):
        done = run(command, bad, folder=tmp_path)
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
        lines = reasons(done)
        assert lines
        assert all("bad.toml" in line for line in lines)
        assert any(words in line for line in lines)
    assert not (tmp_path / "out").exists()


def test_an_unreadable_file_is_one_line(tmp_path: Path) -> None:
    done = run("reconstruct", tmp_path / "none.toml")
    assert done.returncode == 2
    assert len(reasons(done)) == 1


def test_an_out_that_is_a_file_is_refused_before_the_work(tmp_path: Path) -> None:
    file = tmp_path / "taken"
    file.write_text("mine")
    done = run("reconstruct", SCENE, "--out", file / "deeper")
    assert done.returncode == 2
    assert "taken" in done.stderr
    assert file.read_text() == "mine"


# chains on the fullest model, and the ladder, as `.ci/run` does once, take a minute and a half cold
@pytest.mark.parametrize(
    "model",
    [
        "planar-moment+wheels",
        *(pytest.param(model, marks=pytest.mark.slow) for model in ("planar-moment+spin", "auto")),
    ],
)
def test_reconstruct_writes_everything_and_keeps_what_was_there(model: str, tmp_path: Path) -> None:
    out = tmp_path / "case"
    out.mkdir()
    (out / "notes.txt").write_text("mine")
    (out / "summary.json").write_text("old")
    method = "importance" if model == "planar-moment+wheels" else "auto"
    asked = ("--model", model, "--method", method, "--units", "us", "--seed", 3)
    done = run("reconstruct", SCENE, "--out", out, *asked, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (out / "notes.txt").read_text() == "mine"
    assert {p.name for p in out.iterdir()} == {
        "notes.txt", "posterior.nc", "run.json", "scene.toml", "summary.json", "report.html", "figures",
    }  # fmt: skip
    assert {p.name for p in (out / "figures").iterdir()} == {
        "posterior.png", "pair.png", "scene.png", "scene.svg", "delta_v.png", "predictive.png",
        "tornado.png",
    }  # fmt: skip
    assert "mph" in done.stdout
    assert "retrodict: " not in done.stdout
    assert not reasons(done)
    lines = done.stderr.splitlines()
    assert re.fullmatch(r"retrodict: \d s: (starting|loading the libraries)", lines[0])
    # rungs may follow each other faster than lines do
    if model == "auto":
        assert any(re.search(r": \S+\+\S+ \(\d of \d\)", line) for line in lines)

    summary = json.loads((out / "summary.json").read_text())
    assert summary["checks"]["passed"], summary["checks"]
    assert summary["checks"]["divergences"] == (None if method == "importance" else 0)
    assert summary["seed"] == 3
    assert set(summary["seconds"]) >= {"total", "compile", "sample"}
    names = ("speed_b", "e", "e_m", "mu", "vbx", "vby", "omega_b")
    assert tuple(summary["parameters"])[:7] == names
    truth = {"speed_b": 19.3, "e": 0.10, "e_m": 0.70, "mu": 0.35}
    for name in names:
        row = summary["parameters"][name]
        assert row["rhat"] <= 1.01
        assert row["ess_bulk"] >= 1000
        assert row["ess_tail"] >= 1000
        if name in truth:
            low, high = row["interval_90"]
            assert low < truth[name] < high

    idata = arviz.from_netcdf(out / "posterior.nc")
    assert float(idata["posterior"]["speed_b"].mean()) == pytest.approx(
        summary["parameters"]["speed_b"]["mean"]
    )
    assert (out / "report.html").read_text().count("<script") == 2  # the replay's data and code


@pytest.mark.slow
def test_too_few_draws_are_marked_as_not_to_be_relied_on(tmp_path: Path) -> None:
    asked = ("--model", "planar-moment+spin", "--method", "importance", "--draws", 20)
    done = run("reconstruct", SCENE, "--out", tmp_path / "few", *asked)
    assert done.returncode == 0, done.stderr
    assert "NOT TO BE RELIED ON" in done.stdout
    summary = json.loads((tmp_path / "few" / "summary.json").read_text())
    assert not summary["checks"]["passed"]
    assert summary["checks"]["reasons"]


def interrupted(*asked: object) -> str:
    """What a run prints that is interrupted once it has draws."""
    command = [str(RETRODICT), *map(str, asked), "100000"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT
    ) as process:
        assert process.stderr is not None
        for line in process.stderr:
            if re.search(r": \S+\+\S+: sampling, [1-9]", line):  # more than the warm-up
                process.send_signal(signal.SIGINT)
                break
        printed, _ = process.communicate()
    assert process.returncode == 130
    return printed


@pytest.mark.slow
def test_quiet_is_silent_and_ctrl_c_keeps_the_draws(tmp_path: Path) -> None:
    out = tmp_path / "cut"
    asked = ("reconstruct", SCENE, "--model", "planar-moment+spin", "--out", out, "--draws")
    interrupted(*asked)
    assert not json.loads((out / "summary.json").read_text())["checks"]["passed"]
    chains = (out / "chains.npz").read_bytes()
    (out / "chains.npz").write_bytes(chains[: len(chains) // 2])
    refused = run(*asked, 20, "--resume")
    assert refused.returncode == 2
    (line,) = reasons(refused)
    assert line.startswith(f"--resume: {out / 'chains.npz'} is damaged")

    done = run(*asked, 20, "--quiet")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_ctrl_c_leaves_a_finished_result_alone(tmp_path: Path) -> None:
    out = tmp_path / "done"
    out.mkdir()
    finished = {"complete": True, "checks": {"passed": True}, "files": {}}
    (out / "summary.json").write_text(json.dumps(finished))
    (out / "report.html").write_text("finished")
    asked = ("reconstruct", SCENE, "--model", "momentum+slide", "--method", "nuts")
    asked += ("--out", out, "--draws")
    assert "is from the previous, completed run; --resume" in interrupted(*asked)
    assert {p.name for p in out.iterdir()} == {"summary.json", "report.html", "chains.npz"}
    assert (out / "report.html").read_text() == "finished"


@pytest.mark.slow
def test_report_writes_every_format_of_a_saved_run(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "FIGURES", {})
        Result(make_outcome()).save(folder)
    (tmp_path / "case.toml").write_text('schema = 1\nnumber = "17/26"\nunits = "us"\n')
    out = tmp_path / "report"
    asked = ("report", folder, "--out", out, "--case", tmp_path / "case.toml", "--format")
    done = run(*asked, "html,pdf,docx")
    assert done.returncode == 0, done.stderr
    written = [out / f"report.{suffix}" for suffix in ("html", "pdf", "docx")]
    assert done.stdout.split() == [str(file) for file in written]
    assert sorted(out.iterdir()) == sorted(written)
    page = written[0].read_text("utf-8")
    assert "17/26" in page
    assert page.index("US customary units") < page.index("SI units")  # the case's come first
    refused = run(*asked, "odt")
    assert refused.returncode == 2
    assert reasons(refused) == ["--format odt: no document format 'odt': choose of html, pdf, docx"]
    (tmp_path / "case.toml").write_text('schema = 1\nattachments = [{ file = "../x" }]\n')
    refused = run(*asked, "html")
    assert refused.returncode == 2
    assert "attachments[0].file" in refused.stderr


def test_report_of_a_folder_without_a_result_is_refused(tmp_path: Path) -> None:
    refused = run("report", tmp_path)
    assert refused.returncode == 2
    assert "holds no result: summary.json is missing or damaged" in reasons(refused)[0]


def test_results_of_two_runs_show(tmp_path: Path) -> None:
    digest = hashlib.sha256(b"mine").hexdigest()
    (tmp_path / "summary.json").write_text(json.dumps({"files": {"report.html": digest}}))
    (tmp_path / "report.html").write_text("mine")
    assert "fine" in run("check", tmp_path).stdout
    (tmp_path / "report.html").write_text("of another")
    mixed = run("check", tmp_path)
    assert mixed.returncode == 2
    assert "not of the run that summary.json is of: report.html" in mixed.stderr


@pytest.mark.parametrize(
    ("out", "said"),
    [pytest.param("", "--out is empty", marks=pytest.mark.slow), (".", "--out is empty")],
)
def test_the_current_folder_is_not_written_to(tmp_path: Path, out: str, said: str) -> None:
    done = run("reconstruct", SCENE, "--out", out, folder=tmp_path)
    assert done.returncode == 2
    assert reasons(done)[0].startswith(said)
    (tmp_path / "...toml").write_text(SCENE.read_text())
    done = run("reconstruct", "...toml", folder=tmp_path)
    assert done.returncode == 2
    assert "choose one with --out" in done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["...toml"]


def test_names_do_not_steer_the_terminal(tmp_path: Path) -> None:
    done = run("check", tmp_path / "\x1b[2Jscene.toml")
    assert done.returncode == 2
    assert "\x1b" not in done.stderr
    assert r"\x1b[2Jscene.toml" in done.stderr


@pytest.mark.slow
def test_an_encoding_that_lacks_a_character_and_a_wrong_platform_are_survived() -> None:
    poor = ENVIRONMENT | {"PYTHONIOENCODING": "ascii", "JAX_PLATFORMS": "abacus"}
    asked = {"capture_output": True, "text": True, "env": poor, "cwd": ROOT, "check": False}
    done = subprocess.run([str(RETRODICT), "check", str(SCENE)], **asked)
    assert done.returncode == 0, done.stderr
    refused = subprocess.run([str(RETRODICT), "reconstruct", str(SCENE), "--out", "none"], **asked)
    assert refused.returncode == 2
    assert any(line.startswith("JAX_PLATFORMS=abacus: ") for line in refused.stderr.splitlines())


def test_the_option_names_every_method() -> None:
    """Spelled out in the command, so that --help need not import JAX; it must not fall behind."""
    assert [choice.value for choice in MethodChoice] == list(METHODS)


@pytest.mark.slow
def test_ladder_writes_its_files_and_states_the_choice(tmp_path: Path) -> None:
    out = tmp_path / "case"
    done = run("ladder", SCENE, "--out", out, "--seed", 3)
    assert done.returncode == 0, done.stderr
    assert {p.name for p in out.iterdir()} == {
        "ladder.json", "ladder.csv", "ladder.png", "ladder.svg",
    }  # fmt: skip
    content = json.loads((out / "ladder.json").read_text())
    assert content["choice"] in {step["name"] for step in content["steps"] if step["answers"]}
    assert " ".join(content["reason"].split()) in " ".join(done.stdout.split())
    refused = run("ladder", tmp_path / "none.toml")
    assert refused.returncode == 2
    assert len(reasons(refused)) == 1


@pytest.mark.slow
def test_calibrate_writes_its_files_and_goes_on(tmp_path: Path) -> None:
    out = tmp_path / "ranks"
    asked = ("calibrate", "--model", "momentum+slide", "--out", out, "--simulations")
    done = run(*asked, 6)
    assert done.returncode == 0, done.stderr
    assert {p.name for p in out.iterdir()} == {
        "calibration.json", "calibration.csv", "calibration.png", "calibration.svg",
    }  # fmt: skip
    first = (out / "calibration.csv").read_text()
    done = run(*asked, 8)
    assert done.returncode == 0, done.stderr
    assert (out / "calibration.csv").read_text().startswith(first)
    assert json.loads((out / "calibration.json").read_text())["done"] == 8
    refused = run(*asked, 8, "--seed", 1)
    assert refused.returncode == 2
    (line,) = reasons(refused)
    assert "is of another calibration" in line
    refused = run("calibrate", "--model", "momentum", "--out", out)
    assert refused.returncode == 2
    assert reasons(refused)[0].startswith("--model momentum: choose one of momentum+slide, ")


@pytest.mark.slow
def test_validate_scores_a_case_and_reports_faulty_files(tmp_path: Path) -> None:
    """Momentum: 2200 kg at 10 m/s meet 1379 kg; both go on at 2 m/s, so that these came at 10.76 m/s."""
    text = (ROOT / "examples" / "ricsac-11" / "scene.toml").read_text()
    known = ("approach.speed = .*", 'approach.speed = "10 ± 0.1 m/s"')
    departure = ('departure.direction = "-10 ± 2 deg"', 'departure.speed = "2 ± 0.1 m/s"')
    for pattern, new in (
        known,
        ("value = 180,", "value = 170,"),
        ("departure.delta_v = .*", departure[0]),
        ("departure.yaw_rate = .*", departure[1]),
    ):
        text, number = re.subn(pattern, new, text)
        assert number
    good, bad = tmp_path / "cases" / "good", tmp_path / "cases" / "bad"
    for folder in (good, bad):
        folder.mkdir(parents=True)
        (folder / "scene.toml").write_text(text)
    truth = 2200 / 1379 * 8 - 2  # B's: against A's way
    (good / "truth.toml").write_text(
        f'speed_b = {{ value = {truth}, unit = "m/s", source = "eq 19" }}'
    )
    (bad / "truth.toml").write_text("speed_b = 9\n")
    options = ("--model", "momentum+slide", "--method", "importance", "--out", tmp_path / "out")
    done = run("validate", tmp_path / "cases", *options)
    assert done.returncode == 2
    (line,) = reasons(done)
    assert line.startswith(f"{bad / 'truth.toml'}: speed_b = 9: no unit")
    assert "good" in done.stdout
    assert "retrodict: " not in done.stdout
    assert re.search(r"(?m)^retrodict: .* s: bad \(1 of 2\): momentum\+slide: ", done.stderr)
    quiet = run("validate", tmp_path / "cases", *options, "--quiet")
    assert (quiet.stdout, quiet.stderr.splitlines()) == ("", [line])
    of_bad, of_good = json.loads((tmp_path / "out" / "validation.json").read_text())["scores"]
    assert (of_bad["case"], of_bad["passed"], of_bad["truth"]) == ("bad", False, None)
    assert of_good["passed"], of_good["reasons"]
    # the posterior's own median lies 0.05 sd lower (60 000 draws); that of 2000 is sure to 0.03 sd
    assert abs(of_good["error"] / of_good["answer"]["sd"] + 0.05) < 0.1


@pytest.mark.slow
def test_validate_refuses_a_folder_without_cases(tmp_path: Path) -> None:
    done = run("validate", tmp_path)
    assert done.returncode == 2
    assert done.stderr.strip().endswith(
        "write a folder whose folders hold scene.toml and truth.toml"
    )


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("saved") / "run"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "FIGURES", {})
        return Result(make_outcome()).save(folder)


@pytest.mark.slow
def test_export_writes_what_is_asked_for_beside_the_result(saved: Path, tmp_path: Path) -> None:
    done = run("export", saved, "--format", "motion,dxf", "--draw", "17", "--rate", "10")
    assert done.returncode == 0, done.stderr
    names = ["motion/a-draw-17.csv", "motion/b-draw-17.csv", "motion/motion.json", "scene.dxf"]
    assert done.stdout.split() == [str(saved / "export" / name) for name in names]
    assert "fine" in run("check", saved).stdout  # the result is as it was
    done = run("export", saved, "--out", tmp_path / "new" / "files", "--quiet")
    assert done.returncode == 0, done.stderr
    assert done.stdout == ""
    assert {p.name for p in (tmp_path / "new" / "files").iterdir()} == {
        "motion", "tables", "scene.dxf", "scene.svg", "draws.nc", "draws.parquet",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("asked", "status", "said"),
    [
        pytest.param(
            ("--format", "obj"),
            2,
            "no format 'obj' to export: choose of motion, dxf, svg, ",
            marks=pytest.mark.slow,
        ),
        (("--format", "motion", "--draw", "99"), 2, "no draw '99': write median, a percentage"),
        pytest.param(
            ("--rate", "0"), 2, "0 frames a second: write a rate above 0", marks=pytest.mark.slow
        ),
        pytest.param(
            ("--before", "-1"), 2, "-1 s before the impact: write 0 to 60 s", marks=pytest.mark.slow
        ),
        (("--out", "run.json"), 2, "run.json is a file, not a folder"),
        pytest.param(
            ("--format", "motion", "--out", "/proc/none"),
            1,
            "/proc/none: cannot write the files: ",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_an_export_that_cannot_be_is_one_line(
    saved: Path, asked: tuple[str, ...], status: int, said: str
) -> None:
    done = run("export", saved, *asked, folder=saved)
    assert done.returncode == status
    (line,) = reasons(done)
    assert said in line


@pytest.mark.slow
def test_export_of_what_is_no_result_is_one_line(saved: Path, tmp_path: Path) -> None:
    for place, said in (
        (tmp_path / "none", "no such folder; give the folder of a result"),
        (tmp_path, "holds no result: summary.json is missing or damaged"),
        (saved / "run.json", "an archive is left as it is; name a folder for the files with --out"),
    ):
        done = run("export", place)
        assert done.returncode == 2
        (line,) = reasons(done)
        assert said in line
    done = run("export", saved / "run.json", "--out", tmp_path / "new")
    assert done.returncode == 2
    assert "archive" in reasons(done)[0]
    assert not (tmp_path / "new").exists()


def test_an_interrupted_export_is_one_line_and_writes_nothing(
    saved: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setitem(export.EXPORTS, "svg", interrupted)
    out = tmp_path / "new"
    done = CliRunner().invoke(app, ["export", str(saved), "--out", str(out), "--quiet"])
    assert (done.exit_code, done.stderr) == (130, "interrupted\n")
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere/*.toml"], "nowhere/*.toml: no scene file is there"),
        ([SCENE, "--workers", 2, "--scheduler", "tcp://127.0.0.1:9"], "choose one of them"),
        pytest.param(
            [SCENE, "--model", "momentum"],
            "--model momentum: choose auto or one of ",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            [SCENE, "--device", "gpu"],
            "--device gpu: JAX finds no GPU here: install jax[cuda13]",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            [SCENE, "--scheduler", "tcp://127.0.0.1:9"],
            "--scheduler tcp://127.0.0.1:9: nothing ans",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_batch_that_cannot_begin_is_one_line_and_status_2(tmp_path, arguments, said) -> None:
    if "gpu" in arguments and os.path.exists("/dev/nvidia0"):
        pytest.skip("there is one")
    done = run("batch", *arguments, "--out", tmp_path / "out")
    assert done.returncode == 2, done.stderr
    (line,) = reasons(done)
    assert said in line
