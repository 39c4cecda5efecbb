import io
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import fromstring

import matplotlib.image
import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection
from matplotlib.patches import Ellipse, Polygon, Wedge
from matplotlib.text import Text

from retrodict.findings.run_outs import motions
from retrodict.report.figures import registry as figures
from retrodict.report.figures.drawing import IMAGES, new_figure, to_png, to_svg
from retrodict.report.figures.plan_geometry import (
    area_of,
    half_plane,
    impact_pose,
    outline,
    skid_lines,
)
from retrodict.report.figures.registry import (
    ASKED,
    FIGURES,
    figures_of,
    images,
)
from retrodict.report.figures.scene import plan_figure
from retrodict.scene import parse_scene
from retrodict.scene.records import Edge, Measured
from tests.report.conftest import found_of
from tests.shared.scene_file import OIL, SCENE, stripped

NEEDS = (
    ("scene", "trajectories"),
    ("delta_v", "posterior"),
    ("posterior", "prior"),
    ("posterior", "posterior"),
    ("pair", "posterior"),
    ("predictive", "posterior"),
    ("predictive", "posterior_predictive"),
)


def drawn(name, outcome, units="si"):
    return FIGURES[name].draw(found_of(outcome), outcome, units)


def words(figure):
    return "\n".join(text.get_text() for text in figure.findobj(Text))


def test_a_figure_shows_itself_in_a_notebook() -> None:
    """Where pyplot was never imported nobody has taught IPython to show figures."""
    assert new_figure(1, 1)._repr_png_().startswith(b"\x89PNG")


@pytest.mark.slow
def test_figures_are_images_of_print_quality(outcome):
    found = images(found_of(outcome), outcome, "si")
    assert list(found) == list(FIGURES)
    for png in found.values():
        image = matplotlib.image.imread(io.BytesIO(png))
        assert image.shape[1] >= 150 * 6  # at least 150 dpi over six inches
        assert image[..., :3].std() > 0.05  # something is drawn


@pytest.mark.parametrize(("name", "group"), NEEDS)
def test_a_figure_draws_without_a_group_it_shows(outcome, drop, name, group):
    drawn(name, drop(outcome, group), "si").draw_without_rendering()


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_draws_without_any_group(outcome, name):
    drawn(name, replace(outcome, idata=xr.DataTree()), "si").draw_without_rendering()


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_draws_where_rests_are_missing(sparse, name):
    drawn(name, sparse, "us").draw_without_rendering()


def test_unknown_speeds_of_both_stand_side_by_side(outcome, sparse):
    for name, label in (("posterior", "Impact speed of A"), ("pair", "impact speed of A (m/s)")):
        assert label in words(drawn(name, sparse, "si"))
        assert label not in words(drawn(name, outcome, "si"))


def test_the_scene_draws_what_was_measured_and_nothing_else(outcome, sparse):
    full, other = (words(drawn("scene", o, "si")).split("\n") for o in (outcome, sparse))
    new = {"mark B1", "mark B2", "direction of travel ± 2 sd"}
    new |= {"end of rotation, measured"}
    assert new <= set(other)
    assert not new & set(full)
    assert {"A rest", "B rest"} <= set(full)
    assert "B rest" in other
    assert "A rest" not in other
    nothing = {"rest": {}, "marks": {}, "departure": {}, "end_of_rotation": {}}
    tree = sparse.idata.copy()
    del tree["log_likelihood"]  # of evidence that is no longer there
    bare = replace(sparse, scene=replace(sparse.scene, **nothing), idata=tree)
    assert "rest" not in words(drawn("scene", bare, "si"))


def test_run_outs_to_where_no_rest_was_measured_are_in_the_picture(sparse):
    axes = drawn("scene", sparse, "si").axes[0]
    ends = sparse.idata["trajectories"]["path"].isel(step=-1)
    for v in "ab":
        x, y = (ends.sel(vehicle=v, pose=pose).median() for pose in "xy")
        room = sparse.scene.vehicles[v].length / 2
        assert axes.get_xlim()[0] + room < x < axes.get_xlim()[1] - room
        assert axes.get_ylim()[0] + room < y < axes.get_ylim()[1] - room


def test_marks_and_directions_are_drawn_where_they_were_measured(sparse):
    axes = drawn("scene", sparse, "us").axes[0]
    crosses = [line.get_xydata()[0] for line in axes.lines if line.get_marker() == "x"]
    assert np.array(crosses) * 0.3048 == pytest.approx(np.array([[2.0, -1.5], [4.5, -5.0]]))
    (diamond,) = [line for line in axes.lines if line.get_marker() == "D"]
    assert diamond.get_xydata()[0] * 0.3048 == pytest.approx(np.array([5.5, -7.0]))
    first, second = [patch for patch in axes.patches if isinstance(patch, Wedge)]
    x, y, _ = impact_pose(sparse.scene, "a")
    assert np.array(first.center) * 0.3048 == pytest.approx([x, y])
    assert (first.theta1, first.theta2) == pytest.approx((124, 156))
    assert np.array(second.center) * 0.3048 == pytest.approx([4.5, -5.0])
    assert (second.theta1, second.theta2) == pytest.approx((-67, -43))


def test_every_item_of_evidence_has_its_row(sparse):
    text = words(drawn("predictive", sparse, "si"))
    for row in found_of(sparse).measured:
        assert row.measured.sd == 0 or row.label in text
    assert "0.00 ± 0.15 m *" in text


def test_a_missing_variable_is_said_in_its_panel(outcome, drop):
    text = words(drawn("posterior", drop(outcome, "posterior"), "si"))
    assert "no draws of restitution e" in text


@pytest.mark.parametrize("name", FIGURES)
@pytest.mark.parametrize("units", [pytest.param("si", marks=pytest.mark.slow), "us"])
def test_figures_are_labelled_in_the_units_asked_for(outcome, name, units):
    text = words(drawn(name, outcome, units))
    symbols = {"scene": ("x (m)", "x (ft)"), "delta_v": ("along (m/s)", "along (mph)"),
               "posterior": ("m/s", "mph"),
               "pair": ("impact speed of B (m/s)", "impact speed of B (mph)"),
               "predictive": ("20.10 ± 0.50 m/s", "45.0 ± 1.1 mph"),
               "tornado": ("impact speed of B (m/s)", "impact speed of B (mph)")}  # fmt: skip
    wanted, other = symbols[name] if units == "si" else symbols[name][::-1]
    assert wanted in text
    assert other not in text


@pytest.mark.parametrize(
    "name", [n if n == "posterior" else pytest.param(n, marks=pytest.mark.slow) for n in FIGURES]
)
def test_only_a_failed_run_has_a_banner(outcome, failing, name):
    assert "NOT TO BE RELIED ON" in words(drawn(name, failing, "si"))
    assert "NOT TO BE RELIED ON" not in words(drawn(name, outcome, "si"))


def test_numbers_in_figures_of_a_failed_run_are_marked_or_withheld(failing):
    text = words(drawn("posterior", failing, "si"))
    assert "19.1 m/s†" in text
    assert "90 %: 17.7 to 20.6†" in text
    assert "withheld" in text
    assert "0.704" not in text
    pair = words(drawn("pair", failing, "si"))
    assert pair.count("withheld") == 3  # e_m with each of the others


def test_correlations_are_those_of_the_draws(outcome):
    data = outcome.idata["posterior"]
    r = np.corrcoef(data["speed_b"].values.ravel(), data["mu"].values.ravel())[0, 1]
    assert f"{r:.2f}" in words(drawn("pair", outcome, "si"))


def test_evidence_far_from_what_is_predicted_stays_in_the_picture(outcome):
    far = replace(outcome.scene.rest["a"], x=Measured(40.0, 0.1))
    scene = replace(outcome.scene, rest={**outcome.scene.rest, "a": far})
    figure = drawn("predictive", replace(outcome, scene=scene), "si")
    assert "sd" in words(figure)
    low, high = figure.axes[0].get_xlim()
    assert high - low < 30


@pytest.mark.slow
def test_constant_draws_do_not_break_a_figure(outcome):
    tree = outcome.idata.copy()
    tree["posterior"]["e"] = tree["posterior"]["e"] * 0 + 0.1
    still = replace(outcome, idata=tree)
    for name in ("posterior", "pair"):
        drawn(name, still, "si").draw_without_rendering()


def test_names_of_surfaces_are_not_read_as_formulae(outcome):
    odd = replace(outcome.scene.surfaces[1], name=r"$\frac{")
    scene = replace(outcome.scene, surfaces=(outcome.scene.surfaces[0], odd))
    to_png(drawn("scene", replace(outcome, scene=scene), "si"))


def test_what_is_drawn_alike_is_written_alike(outcome):
    once, again = (to_svg(drawn("predictive", outcome, "si")) for _ in range(2))
    assert once == again
    assert b"<svg" in once


def test_the_scene_is_saved_as_a_drawing_that_holds_no_text_to_run(outcome):
    odd = replace(outcome.scene.surfaces[1], name="<script>alert(1)</script>")
    scene = replace(outcome.scene, surfaces=(outcome.scene.surfaces[0], odd))
    found = replace(outcome, scene=scene)
    (drawing,) = figures.svgs(found_of(found), found).values()
    root = fromstring(drawing)
    names = {element.tag.rpartition("}")[2] for element in root.iter()}
    assert "script" not in names
    assert {"path", "clipPath"} <= names
    assert b"dc:date" not in drawing


def test_outlines_on_the_way_lie_on_the_median_draw(outcome):
    (motion,) = motions(outcome, 1)
    axes = drawn("scene", outcome).axes[0]
    wheels = [
        c for c in axes.collections if isinstance(c, LineCollection) and len(c.get_paths()) == 4
    ]
    for v, collection in zip("ab", wheels, strict=True):
        ways = np.array([path.vertices for path in collection.get_paths()])
        car = outcome.scene.vehicles[v]
        share = car.rear_axle.value / (car.front_axle.value + car.rear_axle.value)
        front, rear = ways[:2].mean(axis=0), ways[2:].mean(axis=0)
        # the centre of gravity divides the wheelbase by the axles' distances
        assert rear + share * (front - rear) == pytest.approx(motion.pose[v][:, :2])


def test_impact_centre_lies_at_the_lever_from_the_centre_of_gravity(outcome):
    scene = outcome.scene
    x, y, heading = impact_pose(scene, "a")
    # A heads along -x and is struck ahead of itself, a little to its left
    assert (x, y, heading) == pytest.approx((2.09 * np.cos(0.098), 2.09 * np.sin(0.098), np.pi))


def test_outline_keeps_size_and_points_ahead(outcome):
    vehicle = outcome.scene.vehicles["b"]
    corners = outline(vehicle, (3.0, 4.0, np.pi / 2))
    sides = np.linalg.norm(np.diff(corners[:4], axis=0), axis=1)
    assert sides == pytest.approx([vehicle.length, vehicle.width, vehicle.length])
    assert corners[4] == pytest.approx([3.0, 4.0 - 0.075 + 2.45])  # the tip, up along y


@pytest.mark.parametrize(("side", "inside"), [("left", (0, 5)), ("right", (0, -5))])
def test_a_surface_lies_beyond_its_edge_shifted_by_its_offset(side, inside):
    edge = Edge(0.0, 0.0, 0.0, side, Measured(1.0))
    corners = half_plane(edge, (-10.0, 10.0, -10.0, 10.0))
    sign = np.sign(inside[1])
    assert sorted({float(round(y, 6)) for y in corners[:, 1]}, key=abs) == [sign, sign * 10]
    assert half_plane(replace(edge, y=sign * 30.0), (-10.0, 10.0, -10.0, 10.0)).size == 0


@pytest.mark.parametrize(("units", "size"), [("si", 1), ("us", 0.3048)])
def test_an_outline_is_drawn_with_its_corners_where_the_view_has_some_of_it(units, size):
    corners = np.array([[3, -5], [7, -6], [8, -3]])
    figure = plan_figure(parse_scene(SCENE + OIL, "bend"), units)
    assert " oil" in words(figure).split("\n")
    drawn = [p.get_xy()[:3] for p in figure.axes[0].patches if isinstance(p, Polygon)]
    assert any(np.allclose(corners / size, each) for each in drawn)
    oil = parse_scene(SCENE + OIL, "bend").surfaces[2]
    for view, seen in (
        ((-10, 10, -10, 10), True),
        ((6, 6.1, -5, -4.9), True),  # all of it
        ((-10, 2, -10, 10), False),
    ):
        assert area_of(oil, view).tolist() == (corners.tolist() if seen else [])


def test_the_report_room_opens_without_matplotlib():
    code = "import sys, retrodict.report; sys.exit('matplotlib' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_times_and_distances_are_drawn_where_they_were_asked(outcome, asked):
    found = found_of(asked)
    assert set(figures_of(found)) - set(FIGURES) == {"timeline"}
    assert set(figures_of(found_of(outcome))) == set(FIGURES)
    drawn_in = {
        units: ASKED["timeline"].draw(found, asked, units).axes[0] for units in ("si", "us")
    }
    (numbers,) = [q.numbers for q in found.questions if q.kind == "time_distance"]
    for units, worth in (("si", 1.0), ("us", 0.3048)):
        of_a = drawn_in[units].lines[0]
        assert of_a.get_xdata() == pytest.approx([-time for time in numbers.times])
        assert of_a.get_ydata() * worth == pytest.approx([row[1] for row in numbers.distances["a"]])


def test_the_tornado_s_longest_bar_is_the_largest_effect(outcome):
    found = found_of(outcome)
    (effects,) = [q.numbers for q in found.questions if q.kind == "one_at_a_time"]
    axes = FIGURES["tornado"].draw(found, outcome, "us").axes[0]
    widths = [bar.get_width() * 0.44704 for bar in axes.patches[::2]]
    assert widths == pytest.approx([each.moved for each in effects[: len(widths)]])
    assert axes.yaxis_inverted()  # the first is at the top


@pytest.mark.parametrize(("units", "symbol"), [("si", "m"), ("us", "ft")])
def test_a_plan_shows_what_was_measured_before_any_run(units, symbol):
    scene = parse_scene(SCENE, "bend")
    plan = plan_figure(scene, units)
    found = words(plan).split("\n")
    for thing in ("A impact", "B impact", "A rest", "B rest", "mark A1", "mark A2", " berm"):
        assert thing in found
    for entry in (
        "contact line (Γ), arrow: normal",
        "measured place ± 2 sd",
        "end of rotation, measured",
    ):
        assert entry in found
    assert f"x ({symbol})" in found
    assert "draw" not in words(plan)
    (axes,) = plan.axes
    size = 1 if units == "si" else 0.3048
    centres = [e for e in axes.patches if isinstance(e, Ellipse)]
    (rest,) = [e for e in centres if e.center == pytest.approx((-5.1 / size, 1.9 / size))]
    sd = scene.evidence()["rest_x_a"].sd
    assert rest.width == pytest.approx(4 * sd / size)
    corners = outline(scene.vehicles["b"], impact_pose(scene, "b"))[:4] / size
    outlines = [
        p.get_xy()[:4] for p in axes.patches if isinstance(p, Polygon) and len(p.get_xy()) == 5
    ]
    assert any(np.allclose(corners, each) for each in outlines)


def test_a_plan_needs_no_measured_rest():
    scene = parse_scene(stripped("departure = { speed = '5 ± 1 m/s' }"), "bare")
    plan_figure(scene).draw_without_rendering()


@pytest.mark.parametrize(
    ("suffix", "start"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")]
)
def test_a_picture_is_of_its_suffix_and_alike_byte_for_byte(suffix, start):
    scene = parse_scene(SCENE, "bend")
    first, second = (IMAGES[suffix](plan_figure(scene)) for _ in range(2))
    assert first.startswith(start)
    assert first == second


def test_a_plan_waits_for_no_library_of_inference():
    code = (
        "import sys, retrodict as rd; rd.load_scene('examples/brach-1977/scene.toml').plot();"
        "assert not {'jax', 'xarray', 'arviz_stats', 'scipy.stats'} & set(sys.modules)"
    )
    root = Path(__file__).parents[3]
    subprocess.run([sys.executable, "-c", code], cwd=root, check=True)


def test_the_scene_of_a_loaded_result_can_be_drawn():
    code = (
        "from retrodict.result import load_result; from retrodict.scene.records import Scene; "
        "assert Scene.plot and Scene._repr_html_"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_skid_is_drawn_as_long_as_it_was_and_in_view(sparse):
    scene = sparse.scene
    ((v, lines),) = skid_lines(scene)
    assert v == "b"
    skid = scene.approach["b"].skid.value
    assert np.hypot(*(lines[:, 1] - lines[:, 0]).T) == pytest.approx([skid, skid])
    assert np.hypot(*(lines[0, 1] - lines[1, 1])) == pytest.approx(scene.vehicles["b"].track.value)
    (axes,) = drawn("scene", sparse).axes
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert (lines[..., 0] > left).all()
    assert (lines[..., 0] < right).all()
    assert (lines[..., 1] > low).all()
    assert (lines[..., 1] < high).all()


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n == "pair" else n for n in FIGURES]
)
def test_text_is_at_least_seven_points_as_printed(outcome, sparse, asked, name):
    """A page of either paper gives a figure 17 cm."""
    for each in (outcome, sparse, asked):
        figure = drawn(name, each)
        printed = 17 / 2.54 / figure.get_size_inches()[0]
        sizes = {t.get_text(): printed * t.get_size() for t in figure.findobj(Text) if t.get_text()}
        assert not {text: size for text, size in sizes.items() if size < 7}


def test_drawing_does_not_wait_for_jax():
    code = (
        "import sys, retrodict.inference.outcome, retrodict.report.figures.registry;"
        "sys.exit('jaxlib' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
