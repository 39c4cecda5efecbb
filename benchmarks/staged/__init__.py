"""Staged collisions of the second set: printed numbers, and the scenes that they make."""
