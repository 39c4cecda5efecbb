"""Every public function says by an example how it is called, and the example runs."""

from __future__ import annotations

import doctest
import inspect
from pathlib import Path

import matplotlib
import pytest

import retrodict as rd
from tests.shared.pages import ROOT

matplotlib.use("agg")

PUBLIC = {name: getattr(rd, name) for name in rd.__all__ if name != "__version__"}
# those that take over four seconds
LONG = {
    "batch", "calibrate", "ladder", "load_result", "log_density", "numpyro_model", "plot_path", "replay",
    "session", "validate",
}  # fmt: skip
FUNCTIONS = [name for name, each in PUBLIC.items() if inspect.isroutine(each)]


def example_of(name: str) -> doctest.DocTest:
    """The examples in the docstring of a public name."""
    doc = inspect.getdoc(PUBLIC[name]) or ""
    return doctest.DocTestParser().get_doctest(doc, {}, name, None, None)


def test_every_public_function_has_an_example() -> None:
    assert len(FUNCTIONS) >= 18
    assert [name for name in FUNCTIONS if not example_of(name).examples] == []


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow if name in LONG else ())
        for name in PUBLIC
        if example_of(name).examples
    ],
)
def test_an_example_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    said: list[str] = []
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    assert runner.run(example_of(name), out=said.append).failed == 0, "".join(said)
