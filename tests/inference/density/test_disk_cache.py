"""Programs kept on disk: they come back as they were, or not at all."""

import os
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.inference.density import disk_cache


def _compiled(function) -> jax.stages.Compiled:
    return jax.jit(function).lower(np.ones((2, 2))).compile()


def test_a_kept_program_gives_the_same_numbers(tmp_path: Path) -> None:
    program = _compiled(lambda x: {"sum": jnp.sin(x).sum(), "key": jax.random.key(3)})
    disk_cache.save(tmp_path / "code" / "a.bin", program)
    again = disk_cache.load(tmp_path / "code" / "a.bin")
    x = np.arange(4.0).reshape(2, 2)
    assert float(again(x)["sum"]) == float(program(x)["sum"])
    assert jax.random.uniform(again(x)["key"]) == jax.random.uniform(jax.random.key(3))


def test_what_does_not_load_is_no_program(tmp_path: Path) -> None:
    assert disk_cache.load(tmp_path / "missing.bin") is None
    (tmp_path / "torn.bin").write_bytes(b"\x80\x05 torn")
    assert disk_cache.load(tmp_path / "torn.bin") is None


def test_a_program_that_calls_lapack_is_not_kept(tmp_path: Path) -> None:
    disk_cache.save(tmp_path / "code" / "a.bin", _compiled(lambda x: jnp.linalg.solve(x, x)))
    assert not (tmp_path / "code" / "a.bin").exists()


def test_only_the_newest_states_of_the_code_are_kept(tmp_path: Path) -> None:
    program = _compiled(lambda x: x + 1)
    for generation in range(5):
        disk_cache.save(tmp_path / str(generation) / "a.bin", program)
    assert {p.name for p in tmp_path.iterdir()} == {"2", "3", "4"}


def test_the_name_distinguishes_programs() -> None:
    names = {disk_cache.path_of("rung", what) for what in ("a", "b")}
    assert len(names) == 2
    before = jax.config.jax_enable_compilation_cache
    jax.config.update("jax_enable_compilation_cache", False)
    try:
        assert disk_cache.path_of("rung", "a") is None
    finally:
        jax.config.update("jax_enable_compilation_cache", before)


def test_a_flipped_bit_is_no_program(tmp_path: Path) -> None:
    path = tmp_path / "code" / "a.bin"
    disk_cache.save(path, _compiled(lambda x: x + 1))
    whole = path.read_bytes()
    for bit in np.random.default_rng(0).integers(8 * len(whole), size=500):
        torn = bytearray(whole)
        torn[bit // 8] ^= 1 << bit % 8
        path.write_bytes(torn)
        assert disk_cache.load(path) is None
    path.write_bytes(whole)
    assert disk_cache.load(path) is not None


def test_a_program_in_the_place_of_another_is_none(tmp_path: Path) -> None:
    ours, other = tmp_path / "code" / "a.bin", tmp_path / "code" / "b.bin"
    disk_cache.save(ours, _compiled(lambda x: x + 1))
    disk_cache.save(other, _compiled(lambda x: x + 2))
    other.replace(ours)
    assert disk_cache.load(ours) is None


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="files have no such modes here")
def test_what_others_may_write_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "code" / "a.bin"
    disk_cache.save(path, _compiled(lambda x: x + 1))
    for place, open_, closed in ((path, 0o620, 0o600), (path.parent, 0o777, 0o700)):
        place.chmod(open_)
        assert disk_cache.load(path) is None
        place.chmod(closed)
        assert disk_cache.load(path) is not None


def test_what_cannot_be_kept_leaves_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    (tmp_path / "gone").symlink_to(tmp_path / "nowhere")
    disk_cache.save(tmp_path / "code" / "a.bin", _compiled(lambda x: x + 1))
    assert disk_cache.load(tmp_path / "code" / "a.bin") is not None
    monkeypatch.setattr(os, "replace", full)
    disk_cache.save(tmp_path / "code" / "b.bin", _compiled(lambda x: x + 2))
    assert [p.name for p in (tmp_path / "code").iterdir()] == ["a.bin"]
