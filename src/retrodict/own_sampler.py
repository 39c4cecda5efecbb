"""A scene's posterior for samplers of the user's own: a log density on R^n, and a NumPyro model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
import numpyro
from jaxtyping import Array, Float
from numpyro import distributions as dist
from numpyro import handlers

from retrodict.inference import own
from retrodict.inference.density.log_density import OUTSIDE, Target, shortened
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.modes import ModeSearch
from retrodict.inference.own import Priors, Terms, with_own
from retrodict.inference.plan import planned
from retrodict.inference.samplers.nuts import refitted
from retrodict.inference.transforms.choice import Coordinates
from retrodict.models.standard_normal import DeviatesOf
from retrodict.notebook import Scene
from retrodict.options import DEFAULT_RUNG, RunOptions
from retrodict.scene.load import as_scene

_SITE = "w"  # name of the coordinates as a sample site


@jax.custom_vjp
def _cut(w: Float[Array, " n"]) -> Float[Array, " n"]:
    """The same point; slopes that come back through it are cut where they are very steep."""
    return w


def _cut_back(_: None, slope: Float[Array, " n"]) -> tuple[Float[Array, " n"]]:
    return (shortened(slope),)


_cut.defvjp(lambda w: (w, None), _cut_back)


def _bounded(value: Float[Array, ""]) -> Float[Array, ""]:
    """A log density that is a number everywhere: to leave the support is a rejection, no divergence."""
    return jnp.where(jnp.isfinite(value), value, -OUTSIDE)


@dataclass(frozen=True, eq=False)
class LogDensity:
    """Log density of a scene's posterior on R^n, in coordinates in which it is near a standard normal.

    Called with a point of shape (n,) it gives a number, exact but for a constant: a pure JAX function
    that `jax.jit`, `jax.vmap` and `jax.grad` take. Slopes over three times as steep as a standard
    normal's are shortened to that, which leaves the density that NUTS or HMC samples the same. Where no
    crash is possible the value is -500.

    Args:
        scene: scene to be reconstructed.
        model: name of the rung.
        share: share of the evidence of the modes that these coordinates cover, by the Laplace
            approximation; less than 1 where other numbers of turns fit as well.
        posterior: the posterior in these coordinates.
    """

    scene: Scene
    model: str
    share: float
    posterior: Posterior

    def __call__(self, w: Float[Array, " n"]) -> Float[Array, ""]:
        """Log density at a point."""
        target, data, transform = self.parts
        return _bounded(target.log_density(_cut(jnp.asarray(w)), data, transform))

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.posterior.size

    @property
    def start(self) -> Float[np.ndarray, " n"]:
        """A point near the mode, from which to begin."""
        return np.zeros(self.size)

    @property
    def inverse_mass_matrix(self) -> Float[np.ndarray, " n"]:
        """Variance of each coordinate, nearly: a metric for HMC and NUTS."""
        return np.ones(self.size)

    def unknowns(self, w: Float[Array, "*any n"]) -> dict[str, Array]:
        """The model's unknowns, what follows from them, and predictions of the evidence.

        Args:
            w: points, shape (*any, n).

        Returns:
            Arrays of shape (*any, ...) by name; SI units and radians.
        """
        found = self._at_rows(jnp.asarray(w).reshape(-1, self.size))
        return {k: v.reshape(*np.shape(w)[:-1], *v.shape[1:]) for k, v in found.items()}

    def coordinates(self, unknowns: Mapping[str, Array]) -> Float[Array, " n"]:
        """The point at which the model's unknowns have these values: the inverse of `unknowns`.

        Args:
            unknowns: value of every sample site of the model, by name.

        Raises:
            NotImplementedError: the coordinates are rest poses, which have no inverse in closed form.
        """
        if not self.posterior.programs.structure.in_deviates:
            raise NotImplementedError('rest poses have no inverse: ask for coordinates="deviates"')
        target, data, _ = self.parts
        handler = DeviatesOf(target.rung.model, {k: jnp.asarray(v) for k, v in unknowns.items()})
        handlers.seed(handler, 0)(target.structure, data)
        u = np.asarray(jnp.concatenate(handler.deviates))
        return jnp.asarray(self.posterior.at_deviates(u[None])[0])

    def log_det(self, w: Float[Array, " n"]) -> Float[Array, ""]:
        """log |d unknowns / d w| at a point: what the model's joint density is multiplied by.

        Args:
            w: the point, shape (n,).
        """
        target, data, transform = self.parts
        found = target.evaluate(jnp.asarray(w), data, transform)
        sites = handlers.substitute(target.rung.model, found.quantities)
        trace = handlers.trace(handlers.seed(sites, 0)).get_trace(target.structure, data)
        samples = (site for site in trace.values() if site["type"] == "sample")
        joint = sum(
            (jnp.sum(s["fn"].log_prob(s["value"])) for s in samples), own.total(found.quantities)
        )
        return found.log_density - joint

    @cached_property
    def _at_rows(self) -> Callable[[Float[Array, "rows n"]], dict[str, Array]]:
        """`unknowns` at each row, compiled once."""
        target, data, transform = self.parts

        def at(row: Float[Array, " n"]) -> dict[str, Array]:
            return target.evaluate(row, data, transform).quantities

        return jax.jit(partial(jax.lax.map, at, batch_size=64))

    @cached_property
    def parts(self) -> tuple[Target, Any, Any]:
        """What the density is computed by: functions, and the scene's and the coordinates' numbers."""
        with jax.ensure_compile_time_eval():  # the first call may be within a trace
            data, transform = jax.device_put((self.posterior.data, self.posterior.transform))
        return self.posterior.programs.target, data, transform


@dataclass(frozen=True, eq=False)
class NumpyroModel:
    """A NumPyro model of a scene, without arguments, for `MCMC(NUTS(model))` and `SVI`.

    Its one latent site is `w`, coordinates in which the posterior is near a standard normal. The model's
    unknowns, and what follows from them, are deterministic sites. Called, it returns these and the
    predictions of the evidence by name, so that a model of your own may call it and add a
    `numpyro.factor`.

    Args:
        density: log density whose coordinates are sampled.
    """

    density: LogDensity

    def __call__(self) -> dict[str, Array]:
        """Sample the coordinates, and weight them by the posterior."""
        target, data, transform = self.density.parts
        standard = dist.Normal(0.0, 1.0).expand((self.density.size,)).to_event(1)
        w = numpyro.sample(_SITE, standard)
        with handlers.block():
            found = target.evaluate(_cut(w), data, transform)
        numpyro.factor("posterior", _bounded(found.log_density) - standard.log_prob(w))
        for name, value in found.quantities.items():
            if "/" not in name:
                numpyro.deterministic(name, value)
        return found.quantities

    def plain(self) -> None:
        """The model as it is written, each unknown a sample site: for `condition` and `render_model`."""
        target, data, _ = self.density.parts
        target.rung.model(target.structure, data)


def log_density(
    scene: Scene | str | Path,
    *,
    model: str = DEFAULT_RUNG,
    coordinates: Literal["auto", "deviates"] = "auto",
    seed: int = 0,
    priors: Priors | None = None,
    extra: Terms | None = None,
) -> LogDensity:
    """The posterior of a scene as a function on R^n, for samplers of your own.

    Args:
        scene: scene to be reconstructed, or the path of a scene file.
        model: name of the rung.
        coordinates: "deviates" for standard normal deviates of all unknowns, which have an inverse;
            "auto" for rest poses where chains mix better in them.
        seed: integer seed of the search for the mode, and of the draws that scale the coordinates.
        priors, extra: priors and likelihood terms of your own, as in `reconstruct`.

    Raises:
        SceneError: the scene file cannot be used.
        ValueError: no model or coordinates have that name.
        Unanswerable: the scene has no posterior under the model.

    Examples:
        >>> import jax
        >>> import retrodict as rd
        >>> density = rd.log_density("examples/brach-1977/scene.toml", model="momentum+spin")
        >>> jax.grad(density)(density.start).shape == (density.size,)
        True
        >>> "speed_b" in density.unknowns(density.start)
        True
    """
    scene = with_own(as_scene(scene), priors, extra)
    by_chains, *_ = planned(scene, RunOptions(model=model))
    kinds = {"auto": by_chains.coordinates, "deviates": Coordinates.DEVIATES}
    if coordinates not in kinds:
        raise ValueError(f"coordinates are one of {', '.join(kinds)}; not {coordinates!r}")
    found = ModeSearch(scene, seed).on(model, kinds[coordinates], weighted=False).found
    posterior = found[0].posterior
    covered = [each for each in found if each.turns == found[0].turns]
    if posterior.basins is None:
        covered = found[:1]
    share = sum(each.mode.weight for each in covered)
    whole = replace(posterior, basins=None).differentiable()
    return LogDensity(found[0].scene, model, share, refitted(whole, seed))


def numpyro_model(
    scene: Scene | str | Path,
    *,
    model: str = DEFAULT_RUNG,
    seed: int = 0,
    priors: Priors | None = None,
    extra: Terms | None = None,
) -> NumpyroModel:
    """A NumPyro model of a scene, for `numpyro.infer`; arguments as of `log_density`.

    Args:
        scene: scene to be reconstructed, or the path of a scene file.
        model: name of the rung.
        seed: integer seed of the search for the mode, and of the draws that scale the coordinates.
        priors, extra: priors and likelihood terms of your own, as in `reconstruct`.

    Raises:
        SceneError: the scene file cannot be used.
        ValueError: no model has that name.
        Unanswerable: the scene has no posterior under the model.

    Examples:
        >>> import jax
        >>> from numpyro.infer import MCMC, NUTS
        >>> import retrodict as rd
        >>> model = rd.numpyro_model("examples/brach-1977/scene.toml", model="momentum+spin")
        >>> mcmc = MCMC(NUTS(model), num_warmup=50, num_samples=50, progress_bar=False)
        >>> mcmc.run(jax.random.key(0))
        >>> mcmc.get_samples()["speed_b"].shape
        (50,)
    """
    return NumpyroModel(log_density(scene, model=model, seed=seed, priors=priors, extra=extra))
