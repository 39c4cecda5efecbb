"""Exceptions that end a reconstruction without a result."""


class Unanswerable(Exception):
    """The scene has no posterior that could be sampled; the message says why, and the fix."""


class Interrupted(Exception):
    """The run was stopped before any draw was kept."""
