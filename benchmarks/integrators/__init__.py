"""Which clock, which solver, how many steps: error of the rest pose against what it costs.

Every method starts from the same scenes, with the friction of `retrodict.mechanics` (smoothed over
a contact patch, not by a fixed speed), and is measured against `tests.shared.reference`.
"""
