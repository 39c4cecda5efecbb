"""The drawing has what was measured and what moved, each on its layer, where it was."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from retrodict import findings
from retrodict.findings.run_outs import motion_of, motions
from retrodict.interchange.plan_drawing import Ellipse, Line, Point, Text
from retrodict.report.scene_layers import scene_drawing
from retrodict.scene.records import Measured, Outline, Surface


@pytest.fixture(scope="module")
def record(outcome):
    return findings.compute(outcome)


def layers(record, outcome, scene=None, **asked):
    drawing = scene_drawing(replace(record, scene=scene or record.scene), outcome, **asked)
    found = {layer.name: layer.shapes for layer in drawing.layers}
    assert len(found) == len(drawing.layers)
    assert all(found.values())
    return found


def of_kind(shapes, kind):
    return [shape for shape in shapes if isinstance(shape, kind)]


def test_every_vehicle_has_its_layers(record, outcome):
    names = {"SURFACES", "IMPACT-POINT", "LABELS", "NOTES"}
    for v in "AB":
        names |= {
            f"{v}-{what}"
            for what in (
                "IMPACT", "REST", "REST-ERROR", "APPROACH", "RUN-OUT", "RUN-OUTS", "WHEELS",
            )
        }  # fmt: skip
    assert set(layers(record, outcome)) == names


def test_rest_poses_and_their_errors_are_where_they_were_measured(record, outcome):
    found, scene = layers(record, outcome), outcome.scene
    for v, rest in scene.rest.items():
        at = (rest.x.value, rest.y.value)
        assert of_kind(found[f"{v.upper()}-REST"], Point) == [Point(at)]
        assert found[f"{v.upper()}-REST-ERROR"] == (Ellipse(at, (2 * rest.x.sd, 2 * rest.y.sd)),)
        body, front = of_kind(found[f"{v.upper()}-REST"], Line)
        # centred between the axles, its front mark ahead
        vehicle = scene.vehicles[v]
        ahead = np.array([np.cos(rest.heading.value), np.sin(rest.heading.value)])
        middle = (vehicle.front_axle.value - vehicle.rear_axle.value) / 2
        assert body.points.mean(axis=0) - at == pytest.approx(middle * ahead)
        assert (front.points[0] - at) @ ahead == pytest.approx(middle + vehicle.length / 2)
    assert found["IMPACT-POINT"][:2] == (Point((0.0, 0.0)), Ellipse((0.0, 0.0), (0.3, 0.3)))


def test_ways_and_wheels_are_those_of_the_draw(record, outcome):
    motion = motion_of(motions(outcome), 17)
    found = layers(record, outcome, draw=17, before=0.5)
    for v, vehicle in outcome.scene.vehicles.items():
        way, approach = found[f"{v.upper()}-RUN-OUT"][0], found[f"{v.upper()}-APPROACH"][0]
        assert way.points == pytest.approx(motion.pose[v][:, :2])
        assert approach.points[1] == pytest.approx(way.points[0])
        assert approach.points[1] - approach.points[0] == pytest.approx(0.5 * motion.before[v])
        assert len(found[f"{v.upper()}-RUN-OUTS"]) == 60
        wheels = np.array([line.points for line in found[f"{v.upper()}-WHEELS"]])
        apart = np.hypot(*(wheels[0] - wheels[1]).T)  # both of the front
        assert apart == pytest.approx(vehicle.track.value)
        far = np.hypot(*(wheels[0] - wheels[2]).T)  # both on the left
        assert far == pytest.approx(vehicle.front_axle.value + vehicle.rear_axle.value)
    assert Text in {type(shape) for shape in found["NOTES"]}
    assert any("draw 17" in note.text for note in found["NOTES"])


def test_marks_and_what_was_not_measured(record, sparse):
    found = layers(record, sparse, sparse.scene)
    assert not {"A-REST", "A-REST-ERROR", "A-MARKS"} & set(found)
    assert not of_kind(found["B-REST"], Line)  # no heading
    marks = [(m.x, m.y) for m in sparse.scene.marks["b"]] + [(5.5, -7.0)]
    assert [point.at for point in of_kind(found["B-MARKS"], Point)] == marks
    labels = [text.text for text in of_kind(found["B-MARKS"], Text)]
    assert labels == ["B1", "B2", "B end of rotation"]


def test_an_edge_lies_where_its_surface_begins(record, outcome):
    line, label = layers(record, outcome)["SURFACES"]
    edge = outcome.scene.surfaces[1].edge
    along = np.array([np.cos(edge.direction), np.sin(edge.direction)])
    left = np.array([-along[1], along[0]])
    assert (line.points - [edge.x, edge.y]) @ left == pytest.approx([0, 0], abs=1e-9)
    shifted = replace(edge, offset=Measured(1.5))  # to the right
    road, berm = outcome.scene.surfaces
    scene = replace(outcome.scene, surfaces=(road, replace(berm, edge=shifted)))
    moved, _ = layers(record, outcome, scene)["SURFACES"]
    assert (moved.points - [edge.x, edge.y]) @ left == pytest.approx([-1.5, -1.5])
    assert label.text == "berm: right of this edge"


def test_an_outline_is_drawn_whole_after_the_edges(record, outcome):
    corners = ((500.0, -5.0), (7.0, -6.0), (8.0, -3.0))
    oil = Surface("oil", Measured(0.2), Measured(0.0), None, Outline(corners, Measured(0.0, 0.2)))
    scene = replace(outcome.scene, surfaces=(*outcome.scene.surfaces, oil))
    *before, line, label = layers(record, outcome, scene)["SURFACES"]
    assert [type(each) for each in before] == [Line, Text]
    assert line.closed
    assert line.points.tolist() == [list(corner) for corner in corners]
    assert label.text == "oil: within this outline"


def test_a_failed_run_says_so_in_its_drawing(record, outcome, failing):
    of_failing = replace(record, checks=failing.checks)
    first = [layers(each, outcome)["NOTES"][0].text for each in (record, of_failing)]
    assert first[0] == outcome.scene.title
    assert first[1].startswith("NOT TO BE RELIED ON")


def test_an_exact_coordinate_makes_a_line_of_the_ellipse(record, outcome):
    contact = replace(outcome.scene.contact, x=Measured(0.2))
    scene = replace(outcome.scene, contact=contact)
    _, line, _ = layers(record, outcome, scene)["IMPACT-POINT"]
    assert line.points == pytest.approx(np.array([[0.2, -0.3], [0.2, 0.3]]))


def test_without_motions_what_was_measured_is_drawn(record, outcome):
    found = layers(record, replace(outcome, idata=xr.DataTree()))
    assert "A-IMPACT" in found
    assert "A-RUN-OUT" not in found
