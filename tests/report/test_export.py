"""What is exported is the result: read back by other libraries, it has its numbers."""

import csv
import io
import json
from dataclasses import replace

import ezdxf
import numpy as np
import pandas as pd
import pytest
import xarray as xr

from retrodict.findings.run_outs import NoMotion, motion_of, motions
from retrodict.report import export, libraries
from retrodict.report.export import EXPORTS, Asked, NotExported
from retrodict.report.libraries import MissingLibrary
from retrodict.result import Result


@pytest.fixture(scope="module")
def exported(outcome, tmp_path_factory):
    folder = tmp_path_factory.mktemp("export")
    files = Result(outcome).export(folder, draws=["median", "5%", "95%", 17])
    assert sorted(files) == sorted(path for path in folder.rglob("*") if path.is_file())
    return folder


def test_motions_end_in_the_rest_poses_of_their_draws(outcome, exported):
    found, about = (
        motions(outcome),
        json.loads((exported / "motion/motion.json").read_text("utf-8")),
    )
    impact = about["impact_time"]
    assert impact == pytest.approx(1, abs=2e-6)
    assert [entry["asked"] for entry in about["draws"]] == ["median", "5%", "95%", "17"]
    data = outcome.idata["trajectories"]["path"]
    for entry in about["draws"]:
        motion = motion_of(found, entry["asked"])
        assert entry["number"] == motion.number
        assert entry["speed"]["b"] == motion.speed["b"]
        for v in "ab":
            frame = pd.read_csv(exported / "motion" / entry["files"][v])
            last = frame.iloc[-1]
            x, y, heading = data.isel(run=motion.number - 1, step=-1).sel(vehicle=v).values
            assert (last["X"], last["Y"]) == pytest.approx((x, y), abs=5.1e-5)
            assert last["Yaw"] == pytest.approx(np.degrees(heading), abs=5.1e-5)
            assert motion.lasts <= last["Time"] - impact < motion.lasts + 1 / 30
            # it comes in at the draw's speed, and the impact falls on a frame
            speed = np.hypot(frame["X"].diff(), frame["Y"].diff()) / frame["Time"].diff()
            assert speed[1:31].to_numpy() == pytest.approx(motion.speed[v], abs=0.01)
            at_impact = frame.loc[30, ["X", "Y"]].to_numpy(float)
            assert at_impact == pytest.approx(motion.pose[v][0, :2], abs=1e-4)


def test_the_drawing_has_the_measured_rest_in_its_own_coordinates(outcome, exported):
    document = ezdxf.readfile(exported / "scene.dxf")
    assert not document.audit().errors
    assert document.header["$INSUNITS"] == 6
    for v, rest in outcome.scene.rest.items():
        (ellipse,) = document.modelspace().query(f"ELLIPSE[layer=='{v.upper()}-REST-ERROR']")
        assert tuple(ellipse.dxf.center)[:2] == pytest.approx(
            (rest.x.value, rest.y.value), abs=1e-9
        )
        assert ellipse.dxf.major_axis.magnitude == pytest.approx(2 * rest.x.sd)
    # every layer of the SVG too
    names = {layer.dxf.name for layer in document.layers} - {"0", "Defpoints"}
    text = (exported / "scene.svg").read_text("utf-8")
    assert {name for name in names if f'id="{name}"' in text} == names


def test_tables_are_those_of_the_report(outcome, exported):
    frame = pd.read_csv(exported / "tables/results.csv", index_col="quantity")
    summary = Result(outcome).summary()
    assert list(frame.index) == list(summary.index)
    assert frame["mean"].to_numpy() == pytest.approx(summary["mean"].to_numpy(float), rel=1e-15)
    assert frame.loc["speed_b", "unit"] == "m/s"
    with (exported / "tables/3-1-measured-and-predicted.csv").open(encoding="utf-8-sig") as file:
        header, *rows = csv.reader(file)
    assert header == ["Item", "Measured ± sd", "Predicted ± sd", "Shift, sd"]
    assert len(rows) == len(outcome.scene.evidence())


def test_no_table_is_lost_for_its_name(asked, monkeypatch):
    found = Result(asked).findings
    written = []
    monkeypatch.setattr(export, "table_csv", lambda header, rows: written.append(header) or b"")
    files = EXPORTS["tables"](found, asked, Asked())
    assert len(files) == len(written) > 15


def test_a_source_that_begins_as_a_formula_is_a_text(outcome):
    evil = '=HYPERLINK("http://x")'
    rest = outcome.scene.rest["a"]
    rest = replace(rest, x=replace(rest.x, source=evil))
    scene = replace(outcome.scene, rest=outcome.scene.rest | {"a": rest})
    changed = replace(outcome, scene=scene)
    files = EXPORTS["tables"](Result(changed).findings, changed, Asked())
    cells = [
        cell
        for content in files.values()
        for row in csv.reader(io.StringIO(content.decode("utf-8-sig")))
        for cell in row
    ]
    assert f"'{evil}" in cells
    assert not [cell for cell in cells if cell.startswith(("=", "@"))]


def test_draws_are_the_same_in_both_files(outcome, exported):
    posterior = outcome.idata["posterior"]
    with xr.open_datatree(exported / "draws.nc", engine="h5netcdf") as tree:
        xr.testing.assert_identical(tree["posterior"].to_dataset().load(), posterior.to_dataset())
    frame = pd.read_parquet(exported / "draws.parquet").set_index(["chain", "draw"])
    assert len(frame) == posterior["speed_b"].size
    for name in ("speed_b", "e", "mass_a"):
        assert frame.loc[(2, 45), name] == posterior[name].sel(chain=2, draw=45).item()


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"formats": ["obj"]}, "no format 'obj' to export: choose of motion, dxf"),
        ({"rate": 0}, "write a rate above 0"),
        ({"rate": float("nan")}, "write a rate above 0"),
        ({"before": -1}, "write 0 to 60 s"),
    ],
)
def test_what_cannot_be_exported_is_refused(outcome, tmp_path, asked, said):
    with pytest.raises(NotExported, match=said):
        Result(outcome).export(tmp_path / "new", **asked)
    assert not (tmp_path / "new").exists()


def test_a_format_that_is_added_is_written(outcome, tmp_path, monkeypatch):
    def toy(findings, outcome, asked):
        return {"deep/toy.txt": findings.scene.title.encode()}

    monkeypatch.setitem(EXPORTS, "toy", toy)
    (file,) = Result(outcome).export(tmp_path, ["TOY"])
    assert file == tmp_path / "deep" / "toy.txt"
    assert file.read_text() == outcome.scene.title


@pytest.mark.parametrize(("name", "refused"), [("motion", NoMotion), ("parquet", NotExported)])
def test_a_format_that_needs_draws_is_left_out_without_them(outcome, name, refused):
    found, empty = Result(outcome).findings, replace(outcome, idata=xr.DataTree())
    with pytest.raises(refused, match=f"leave {name} out"):
        EXPORTS[name](found, empty, Asked())
    for other in sorted(EXPORTS.keys() - {"motion", "parquet"}):
        assert EXPORTS[other](found, empty, Asked())


def test_a_draw_that_there_is_not_writes_nothing(outcome, tmp_path):
    with pytest.raises(NoMotion):
        Result(outcome).export(tmp_path / "new", draws=[61])
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("name", ["dxf", "parquet"])
def test_without_its_library_a_format_says_what_to_install(outcome, monkeypatch, name):
    def missing(module):
        raise ImportError(module)

    monkeypatch.setattr(libraries, "import_module", missing)
    with pytest.raises(MissingLibrary, match=r"pip install .*'ezdxf"):
        EXPORTS[name](Result(outcome).findings, outcome, Asked())
