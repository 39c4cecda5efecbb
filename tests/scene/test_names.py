"""Every name of an input or of an item of evidence is taken apart and put together again."""

from __future__ import annotations

import pytest

from retrodict.scene.names import Name, parsed


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("rest_x_a", Name("rest_x", "a")),
        ("departure_delta_v_left_b", Name("departure_delta_v_left", "b")),
        ("mark_2_b", Name("mark", "b", 2)),
        ("impact_energy_lost_at_most", Name("impact_energy_lost_at_most", "")),
        ("mark_12_speed_a", Name("mark_speed", "a", 12)),
    ],
)
def test_kind_vehicle_and_mark(name: str, parts: Name) -> None:
    assert parsed(name) == parts


def test_where_it_was_measured() -> None:
    assert parsed("rest_heading_a").at_rest
    assert not parsed("rest_heading_a").on_way
    assert parsed("mark_1_course_b").on_way
    assert parsed("end_x_b").on_way
    assert not parsed("departure_speed_a").on_way


@pytest.mark.parametrize("name", ["Gamma", "impact_x", "friction_road"])
def test_what_belongs_to_no_vehicle_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="no vehicle"):
        parsed(name)
