"""Draws as an ArviZ DataTree: what follows from them, predictions, the prior and run-outs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from retrodict.inference.density.compiled import in_chunks
from retrodict.inference.density.kernels import CHUNK, LOG_PRIOR, PATHS
from retrodict.inference.fitting.posterior import Posterior, run_outs_of
from retrodict.inference.modes import Solution
from retrodict.inference.prior_check import Reference
from retrodict.inference.samplers import Draws
from retrodict.models.standard_normal import sizes
from retrodict.scene.quantities import describe, si_symbol
from retrodict.scene.records import FREEDOM

if TYPE_CHECKING:
    import xarray as xr

RUNS = 60


def tree_of(
    solution: Solution, drawn: Draws, seed: int, reference: Reference | None
) -> xr.DataTree:
    """Draws as an ArviZ DataTree, named, with units.

    Args:
        solution: solution that the draws are of.
        drawn: draws of the solution, by any method.
        seed: integer seed of the measurement errors in predictions.
        reference: crashes of the prior, which figures show as they do run-outs; None to record neither.
    """
    import xarray as xr

    posterior, scene = solution.posterior, solution.scene
    programs = posterior.programs
    rng = np.random.default_rng([seed, 1])

    quantities = drawn.known(posterior)

    def group(values: dict[str, np.ndarray], prefix: str, shape: tuple[int, int]) -> xr.Dataset:
        chosen = {
            k.removeprefix(prefix): np.asarray(v).reshape(shape)
            for k, v in values.items()
            if k.startswith(prefix) and (prefix or "/" not in k) and k != "measured"
        }
        return _labelled(chosen, ("chain", "draw"))

    every = scene.evidence()
    evidence = {name: every[name] for name in programs.structure.evidence}

    def noisy(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {
            f"predicted/{k}": values[f"predicted/{k}"]
            + m.sd * _errors(rng, np.shape(values[f"predicted/{k}"]), scene.robust)
            for k, m in evidence.items()
        }

    shape, once = drawn.w.shape[:2], (1, CHUNK)
    groups = {
        "posterior": group(quantities, "", shape),
        "posterior_predictive": group(noisy(quantities), "predicted/", shape),
        "sample_stats": xr.Dataset(
            {k: (("chain", "draw"), v) for k, v in drawn.stats.items()}, attrs=drawn.attributes
        ),
        "observed_data": _labelled({k: np.asarray(m.value) for k, m in evidence.items()}, ()),
        "constant_data": xr.Dataset({f"{k}_sd": m.sd for k, m in evidence.items()}),
    }
    if drawn.conditioned:
        groups["log_likelihood"] = group(quantities, "log_likelihood/", shape)
    if drawn.conditioned and reference is not None:
        groups["log_prior"] = _log_prior(posterior, quantities, shape)
    if reference is not None:
        prior = {k: v[:CHUNK] for k, v in reference.every.items()}
        groups["prior"] = group(prior, "", once)
        weight = reference.weights[:CHUNK].reshape(once)
        weight = weight / weight.sum() if weight.any() else weight
        groups["sample_stats_prior"] = xr.Dataset({"weight": (("chain", "draw"), weight)})
        groups["prior_predictive"] = group(noisy(prior), "predicted/", once)
        groups["trajectories"] = _trajectories(posterior, quantities)
    return xr.DataTree.from_dict({f"/{k}": v for k, v in groups.items()})


def _errors(rng: np.random.Generator, shape: tuple[int, ...], robust: bool) -> np.ndarray:
    """Errors of measurement in standard deviations."""
    return rng.standard_t(FREEDOM, shape) if robust else rng.standard_normal(shape)


def _labelled(values: dict[str, np.ndarray], dims: tuple[str, ...]) -> xr.Dataset:
    import xarray as xr

    variables = {}
    for name, value in values.items():
        label, dimension = describe(name)
        variables[name] = (dims, value, {"unit": si_symbol(dimension), "label": label})
    shape = np.shape(next(iter(values.values()))) if values else ()
    coords = {d: np.arange(size) for d, size in zip(dims, shape, strict=False)}
    return xr.Dataset(variables, coords=coords)


def _log_prior(
    posterior: Posterior, quantities: dict[str, np.ndarray], shape: tuple[int, int]
) -> xr.Dataset:
    """Log prior density of each unknown, and of each measured input's deviate."""
    import xarray as xr

    programs, data = posterior.programs, posterior.data
    sampled = sizes(programs.target.rung.impact, programs.structure, data)
    sites = {name: quantities[name] for name in sampled}
    found = in_chunks(lambda rows: programs(LOG_PRIOR, data, rows), sites)
    of_inputs = found.pop("measured", None)
    known = _labelled({k: v.reshape(shape) for k, v in found.items()}, ("chain", "draw"))
    for name, value in known.data_vars.items():
        known[name] = value.assign_attrs(unit="")
    if of_inputs is None:
        return known
    names = [name for name, _ in programs.structure.uncertain]
    inputs = of_inputs.reshape(*shape, -1)
    of_inputs = xr.DataArray(inputs, dims=("chain", "draw", "input"), coords={"input": names})
    return known.assign(inputs=of_inputs.assign_attrs(unit="", label="measured inputs"))


def _trajectories(posterior: Posterior, quantities: dict[str, np.ndarray]) -> xr.Dataset:
    """Run-outs of draws taken evenly along the chains."""
    import xarray as xr

    V, xi = run_outs_of(quantities)
    index = np.linspace(0, len(V) - 1, RUNS).astype(int)
    vehicles = posterior.programs.structure.vehicles
    taken = posterior.programs(PATHS, posterior.data, V[index], xi[index])
    return xr.Dataset(
        {
            "path": (("run", "vehicle", "step", "pose"), np.asarray(taken["pose"])),
            "time": (("run", "vehicle", "step"), np.asarray(taken["time"])),
            "before": (("run", "vehicle", "axis"), np.asarray(taken["before"])),
        },
        coords={"vehicle": list(vehicles), "pose": ["x", "y", "heading"], "axis": ["x", "y"]},
    )
