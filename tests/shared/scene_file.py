"""A scene file that uses every key, for tests to change."""

SCENE = """\
schema = 1
title = "Two cars on a bend"
notes = ["a remark", "another"]
question = ["mu", "speed_b"]
errors = "robust"

[vehicles.A]
name = "sedan"
mass = "1857 ± 37 kg"
yaw_inertia = "3374 ± 270 kg m^2"
wheelbase = "2.85 m"
cg_to_front_axle = "1.35 m"
cg_to_rear_axle = "1.50 m"
track = "1.54 m"
length = "5.2 m"
width = "1.8 m"
impact_centre = { distance = "2.09 ± 0.05 m", angle = "10 ± 2 deg" }
grip = "1.02 ± 0.04"
marks = [
  { point = ["-2 m", "0.5 m"], of = "front_left", uncertainty = "0.2 m", speed = "4 ± 1 m/s" },
  { point = ["-3 m", { value = 1, unit = "m", source = "taped" }], course = "170 ± 4 deg" },
]
end_of_rotation = { x = "-4 ± 0.5 m", y = "1.5 ± 0.4 m", heading = "200 ± 5 deg" }
steer = "3 ± 2 deg"

[vehicles.A.wheels]
front_left = "locked"
front_right = "rolling"
rear_left = "0.3 ± 0.1"
rear_right = { value = 0.2, sd = 0.05, source = "rubbed" }

[vehicles.A.impact]
heading = "180 ± 2 deg"

[vehicles.A.approach]
speed = "45 ± 2 mph"
direction = "181 ± 2 deg"
yaw_rate = "0 ± 1 deg/s"
skid = "12 ± 0.4 m"

[vehicles.A.departure]
direction = "160 ± 5 deg"
speed = "5 ± 1 m/s"
yaw_rate = "35 ± 5 deg/s"
delta_v_forward = "-13 ± 1 m/s"
delta_v_left = "-2 ± 1 m/s"

[vehicles.A.rest]
position = ["-5.1 ± 0.15 m", "1.9 ± 0.15 m"]
heading = "215 ± 3 deg"
rotation = "35 deg"

[vehicles.B]
mass = "1778 kg"
wheelbase = "2.75 m"
track = "1.52 m"
impact_centre = { distance = "1.76 m", angle = "60 deg" }

[vehicles.B.impact]
heading = "8 deg"

[vehicles.B.departure]
delta_v = "30 ± 2 mph"

[vehicles.B.rest]
position = ["6.1 m", "-9 m"]
heading = "-12 deg"

[impact]
point = ["0.1 ± 0.3 m", "-0.2 ± 0.3 m"]
contact_line = "-8.9 ± 3 deg"

[surfaces.berm]
friction = "0.40 ± 0.03"
speed_dependence = "0.002 ± 0.001 s/m"
edge = { point = ["0 m", "4 m"], direction = "90 deg", side = "left", uncertainty = "0.2 m" }

[surfaces.road]
kind = "dry asphalt"
friction = "0.50 ± 0.03"

[priors.speed_a]
scale = "50 mph"
source = "a survey of A's road"

[priors.speed_b]
scale = "40 mph"
source = "a survey"

[priors.e]
fast = 0.2
slow = 0.6
over = "12 mph"
source = "bumper beams met"
"""

# a surface besides, for scenes that have one
OIL = """
[surfaces.oil]
friction = "0.20 ± 0.03"
outline = { corners = [["3 m", "-5 m"], ["7 m", "-6 m"], ["8 m", "-3 m"]], uncertainty = "0.2 m" }
"""


def changed(*changes: tuple[str, str]) -> str:
    """The scene with the first occurrence of each text replaced by another."""
    text = SCENE
    for old, new in changes:
        assert old in text, f"the example has no {old!r}"
        text = text.replace(old, new, 1)
    return text


def stripped(of_b: str = "") -> str:
    """A scene of two like vehicles, with nothing known of their motion but these lines of B."""
    vehicle = """
[vehicles.{}]
mass = "1857 kg"
wheelbase = "2.85 m"
track = "1.54 m"
impact_centre = {{ distance = "2.09 m", angle = "10 deg" }}
impact = {{ heading = "180 deg" }}
"""
    head = 'schema = 1\ntitle = "Little is known"\n'
    impact = '[impact]\npoint = ["0 m", "0 m"]\ncontact_line = "-8.9 ± 3 deg"\n'
    return head + vehicle.format("A") + vehicle.format("B") + of_b + "\n" + impact


def without(*starts: str) -> str:
    """The scene without the first line that begins so, for each."""
    lines = SCENE.splitlines()
    for start in starts:
        lines.remove(next(line for line in lines if line.startswith(start)))
    return "\n".join(lines)
