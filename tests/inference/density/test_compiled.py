"""Compiled kernels: what is kept of them, and that their memory can be given back."""

from pathlib import Path
from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.inference.density import disk_cache
from retrodict.inference.density.compiled import Programs
from retrodict.inference.density.kernels import Kernel

SINES = Kernel("sines", lambda target, x: jnp.sin(x).cumsum())
X = np.linspace(0.0, 1.0, 5)


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    file = tmp_path / "code" / "sines.bin"
    monkeypatch.setattr(disk_cache, "path_of", lambda *_: file)
    return file


def test_an_unloaded_program_loads_again_and_gives_the_same(kept: Path) -> None:
    programs = Programs(SimpleNamespace(structure=SimpleNamespace(of_python=None)))
    before = programs(SINES, X)
    programs.unload()
    assert not programs._programs
    np.testing.assert_array_equal(programs(SINES, X), before)
    assert programs._anew  # it came from the disk


def test_a_kept_program_holds_no_names_of_operations(kept: Path) -> None:
    Programs(SimpleNamespace(structure=SimpleNamespace(of_python=None)))(SINES, X)
    assert b"/sin" not in kept.read_bytes()
