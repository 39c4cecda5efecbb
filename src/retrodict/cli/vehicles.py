"""The command `retrodict vehicles`."""

from __future__ import annotations


def vehicles() -> None:
    """List the classes and models of vehicles that a scene may name in place of numbers."""
    from rich.console import Console

    from retrodict.report.vehicles import print_vehicles

    print_vehicles(Console())
