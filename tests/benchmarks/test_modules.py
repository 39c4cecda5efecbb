"""Every benchmark finds what it imports of the package: none runs in the tests, and names move."""

from __future__ import annotations

from importlib import import_module
from pkgutil import walk_packages

import benchmarks


def test_every_benchmark_finds_what_it_imports() -> None:
    names = [each.name for each in walk_packages(benchmarks.__path__, "benchmarks.")]
    assert len(names) > 20
    missing = []
    for name in names:
        try:
            import_module(name)
        except ModuleNotFoundError as error:  # of the group `bench`, which tests do without
            missing.append((error.name or "").partition(".")[0])
    assert {"benchmarks", "retrodict", "tests"}.isdisjoint(missing)
