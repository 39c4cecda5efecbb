"""The truth file: what it may hold, and one line with the fix for what it may not."""

import re
from pathlib import Path

import pytest

from retrodict.scene.errors import SceneError
from retrodict.scene.truth import Published, load_truth

GOOD = """\
note = "a remark"
speed_a = { value = 21.47, unit = "mph", source = "a light barrier" }

[[published]]
name = "a program"
speed_a = "24 mph"
source = "its manual"
"""
PAGE = Path(__file__).parents[2] / "docs" / "validation.md"


def load(tmp_path: Path, text: str):
    file = tmp_path / "truth.toml"
    file.write_text(text)
    return load_truth(file)


def test_speeds_are_in_metres_per_second(tmp_path):
    """A mile is 1609.344 m."""
    truth = load(tmp_path, GOOD)
    assert truth.speeds["speed_a"].value == pytest.approx(21.47 * 1609.344 / 3600)
    assert truth.speeds["speed_a"].source == "a light barrier"
    assert truth.published == (
        Published("a program", {"speed_a": pytest.approx(24 * 1609.344 / 3600)}, "its manual"),
    )
    assert truth.note == "a remark"


def test_groups_are_labels(tmp_path):
    assert load(tmp_path, GOOD).groups == {}
    assert load(tmp_path, f'{GOOD}\n[groups]\nface = "rigid"\n').groups == {"face": "rigid"}
    with pytest.raises(SceneError, match=r"kind.*it follows from the scene; leave it out"):
        load(tmp_path, f'{GOOD}\n[groups]\nkind = "barrier"\n')
    many = "".join(f'g{i} = "x"\n' for i in range(9))
    with pytest.raises(SceneError, match="9 groups; write at most 8"):
        load(tmp_path, f"{GOOD}\n[groups]\n{many}")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('unit = "mph", ', "", "speed_a = .*: no unit; add unit = "),
        (', source = "a light barrier"', "", "speed_a = .*: no source is given; write "),
        ("21.47", "-1", "speed_a = .*: not plausible; write a speed between 0 and 335.5 mph"),
        ("value", "sd = 1, value", "speed_a = .*: no uncertainty is used here"),
        ("speed_a = {", "speed_c = {", "speed_c = .*: unknown key; did you mean "),
        ('speed_a = "24 mph"\n', "", r"published\[0\].speed_b: no speed is given"),
        ('source = "its manual"\n', "", r"published\[0\].source: missing; write source = "),
        ('"a remark"', '"a\\u001b[31mremark"', "note = .*: write one line of at most 1000 printable"),
        (GOOD, "note = 'x'", "speed_b: no speed is given; write "),
    ],
)  # fmt: skip
def test_each_fault_is_one_line_with_its_place_and_fix(tmp_path, old, new, said):
    assert old in GOOD
    with pytest.raises(SceneError) as caught:
        load(tmp_path, GOOD.replace(old, new, 1))
    lines = str(caught.value).splitlines()
    found = [line for line in lines if re.search(rf"truth\.toml: {said}", line)]
    assert found, lines


def test_the_example_in_the_docs_is_a_truth_file(tmp_path):
    found = re.search(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert found
    assert set(load(tmp_path, found[1]).speeds) == {"speed_a", "speed_b"}
