"""The report of a calibration: files, verdict, chart, and going on with a table of ranks."""

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from rich.console import Console

from retrodict.interchange.tables import csv_text
from retrodict.report.calibration import (
    RANKS,
    calibrated,
    calibration_data,
    print_calibration,
    read_ranks,
    verdict,
    write_calibration,
    write_ranks,
)
from retrodict.report.figures.calibration import calibration_figure
from retrodict.studies.calibration import MOST_WITHHELD, Calibration, Row, design
from retrodict.studies.uniformity import uniformity


def heavier() -> dict[str, object]:
    """The design with A a kilogram heavier."""
    scene = design()
    a = scene.vehicles["a"]
    a = replace(a, mass=replace(a.mass, value=a.mass.value + 1))
    return {"scene": replace(scene, vehicles=scene.vehicles | {"a": a})}


@pytest.fixture(scope="module")
def calibration() -> Calibration:
    """Sixty simulations: one withheld, speeds uniform, e far too low."""
    ranks = np.random.default_rng(2).integers(0, 100, 60)
    rows = [
        Row(i, {"speed_b": int(r), "e": int(r) // 2}, closing=i / 8) for i, r in enumerate(ranks)
    ]
    rows[7] = Row(7, reason="checks failed: R-hat", closing=0.875)
    return Calibration(design(), "momentum+slide", "nuts", 3, 60, tuple(rows))


def test_the_verdict_names_what_is_not_uniform_and_how_many_were_compared(calibration) -> None:
    said = verdict(calibration, uniformity(calibration))
    assert said.startswith("NOT CALIBRATED: the ranks of e are not uniform.")
    assert "2 quantities were compared, each at 97.50% for 95% over all" in said
    assert "1 of 60 runs (1.7%) were withheld." in said


def test_many_withheld_runs_are_part_of_the_verdict(calibration) -> None:
    good = replace(
        calibration,
        rows=tuple(replace(r, ranks={k: v for k, v in r.ranks.items() if k != "e"})
                   for r in calibration.rows),
    )  # fmt: skip
    found = uniformity(good)
    assert calibrated(good, found)
    few = replace(good, rows=tuple(Row(r.simulation) if r.simulation < 4 else r for r in good.rows))
    assert not calibrated(few, uniformity(few))
    assert "more than 5%" in verdict(few, uniformity(few))


def test_files_hold_the_numbers(calibration, tmp_path) -> None:
    write_calibration(calibration, tmp_path)
    content = json.loads((tmp_path / "calibration.json").read_text())
    assert content["ranked"] == 59
    assert content["withheld_because"] == {"checks failed": 1}
    assert not content["calibrated"]
    assert content["quantities"]["speed_b"]["inside_jointly"]
    assert not content["quantities"]["e"]["inside"]
    rows = list(csv.DictReader(io.StringIO((tmp_path / RANKS).read_text())))
    assert [row["speed_b"] for row in rows][:7] == [
        str(row.ranks["speed_b"]) for row in calibration.rows[:7]
    ]
    assert (tmp_path / "calibration.svg").read_text().startswith("<?xml")
    assert matplotlib.image.imread(tmp_path / "calibration.png").shape[0] > 200


def test_a_table_of_ranks_is_read_back(calibration, tmp_path) -> None:
    assert read_ranks(calibration, tmp_path) == ()
    write_ranks(calibration, tmp_path)
    assert read_ranks(calibration, tmp_path) == calibration.rows


def test_other_words_make_no_other_calibration(calibration, tmp_path) -> None:
    write_ranks(calibration, tmp_path)
    reworded = replace(calibration, scene=replace(calibration.scene, title="another", text=""))
    assert read_ranks(reworded, tmp_path) == calibration.rows


@pytest.mark.parametrize(
    "other",
    [{"seed": 4}, {"model": "planar+spin"}, {"scene": replace(design(), robust=True)}, heavier()],
)
def test_a_table_of_another_calibration_is_refused(calibration, tmp_path, other) -> None:
    write_ranks(calibration, tmp_path)
    with pytest.raises(ValueError, match=r"is of another calibration .* choose another folder"):
        read_ranks(replace(calibration, **other), tmp_path)


def test_a_file_that_is_no_table_of_ranks_is_refused(calibration, tmp_path) -> None:
    (tmp_path / RANKS).write_text("a,b\n1,2\n")
    with pytest.raises(ValueError, match="is not a table of ranks"):
        read_ranks(calibration, tmp_path)


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [
        ("simulation", "2", "has simulation 2 twice"),
        ("simulation", "-1", "has simulation -1 twice, or has none of that number"),
        ("speed_b", "100", "has a rank in simulation 1 that is not in 0 to 99"),
        ("reason", "checks failed", "has in simulation 1 not either ranks or a reason"),
    ],
)
def test_impossible_rows_are_refused_and_named(calibration, tmp_path, column, value, said) -> None:
    write_ranks(calibration, tmp_path)
    rows = list(csv.DictReader(io.StringIO((tmp_path / RANKS).read_text())))
    rows[1][column] = value
    (tmp_path / RANKS).write_text(csv_text(tuple(rows[0]), rows))
    with pytest.raises(ValueError, match=said):
        read_ranks(calibration, tmp_path)


def test_a_line_leaves_its_band_where_the_verdict_says_so(calibration) -> None:
    figure = calibration_figure(calibration)
    drawn = {axes.get_title(loc="left"): axes for axes in figure.axes if axes.lines}
    assert set(drawn) == {"impact speed of B", "e"}
    for axes, inside in ((drawn["impact speed of B"], True), (drawn["e"], False)):
        assert (axes.lines[0].get_linestyle() == "-") is inside  # seen without colour too


def test_nothing_ranked_is_drawn_and_reported_as_such(calibration) -> None:
    empty = replace(calibration, rows=())
    assert calibration_figure(empty).axes[0].texts[0].get_text() == "too few ranks to decide"
    out = io.StringIO()
    print_calibration(empty, Console(file=out, width=100))
    assert "Too few to judge: 0 simulations" in out.getvalue()


def test_a_few_simulations_are_not_judged(calibration) -> None:
    four = replace(calibration, rows=calibration.rows[5:9])  # of which one was withheld
    assert verdict(four, uniformity(four)).startswith("Too few to judge: 4 simulations; from 50 on")
    assert not calibrated(four, uniformity(four))


def test_the_table_states_coverage_and_verdict(calibration) -> None:
    out = io.StringIO()
    print_calibration(calibration, Console(file=out, width=100))
    assert "± 6.5%" in out.getvalue()  # sqrt(0.25 / 59)
    assert "NOT CALIBRATED" in out.getvalue()


def test_crashes_that_close_in_slowly_are_counted_separately(calibration: Calibration) -> None:
    slow = calibration_data(calibration)["closing_slowly"]
    assert (slow["below"], slow["done"], slow["ranked"]) == (3.0, 24, 23)
    assert slow["withheld"] == pytest.approx(1 / 24)
    assert set(slow["quantities"]) == {"speed_b", "e"}


def test_a_table_of_other_plausible_crashes_is_another_calibration(
    calibration: Calibration, tmp_path: Path
) -> None:
    write_ranks(calibration, tmp_path)
    file = tmp_path / "calibration.csv"
    older = [line.rsplit(",", 1)[0] for line in file.read_text().splitlines()]
    older = [line.replace(",closing_from", "").replace(",0.3,", ",", 1) for line in older]
    file.write_text("\n".join(older) + "\n")
    with pytest.raises(ValueError, match=r"another calibration.*closing_from '3\.0'"):
        read_ranks(calibration, tmp_path)


def test_exactly_the_share_that_may_be_withheld_is_not_more(calibration) -> None:
    ranked, withheld = Row(0, {"speed_b": 1}), Row(0)
    assert replace(calibration, rows=(*[ranked] * 190, *[withheld] * 10)).withheld == MOST_WITHHELD
