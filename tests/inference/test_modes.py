"""Several solutions of one scene: all found, weighted by their evidence, and mixed."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np
import pytest
import xarray as xr
from jax.scipy.special import logsumexp
from retrodict.models import RUNGS

from retrodict.inference import modes
from retrodict.inference.density.compiled import Programs, programs_for
from retrodict.inference.density.log_density import Evaluated, Target
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.outcome import Mode
from retrodict.inference.pointwise import by_item
from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.samplers import METHODS, Task
from retrodict.inference.samplers.importance import log_evidence
from retrodict.inference.transforms.choice import Coordinates
from retrodict.options import DEFAULT_RUNG, RunOptions
from retrodict.scene.records import Scene
from retrodict.studies import calibration
from tests.shared.posteriors import from_the_prior
from tests.shared.scenes import collision

SCENE = collision(share=0.0)
APART, SHARE = 10.0, 0.3  # of the toy's second normal: where it lies, and its weight


class _TwoNormals(Target):
    """A density that is known: two standard normals, APART from each other."""

    def evaluate(self, w, data, transform, missed=None):
        squares = jnp.stack([w @ w, w @ w + APART**2 - 2 * APART * w[0]])
        quantities = {f"predicted/{name}": jnp.zeros(()) for name in self.structure.rest_components}
        density = logsumexp(-squares / 2 + jnp.log(jnp.array([1 - SHARE, SHARE])))
        return Evaluated(density, quantities, w, jnp.zeros(len(self.structure.rest_components)))


@pytest.fixture(scope="module")
def two_normals() -> Posterior:
    posterior = prepare(SCENE, DEFAULT_RUNG)
    # of a structure that no scene has: its programs must not be kept as another's
    structure = replace(posterior.programs.structure, steps=1)
    return replace(posterior, programs=Programs(_TwoNormals(structure)))


def _simulated(number: int) -> tuple[Scene, dict]:
    """A crash of the package's calibration: its scene, and what was true."""
    design = calibration.design()
    structure, data = RUNGS[DEFAULT_RUNG].of_scene(design)
    batch, i = divmod(number, calibration._BATCH)
    chance = np.random.default_rng([0, batch])
    sites, quantities = calibration._truths(programs_for(structure), data, chance)
    measured = np.random.default_rng([0, number, 1])
    scene = calibration._measured(
        design, structure, {k: v[i] for k, v in quantities.items()}, measured
    )
    return scene, {k: v[i] for k, v in sites.items()}


@pytest.mark.slow
def test_the_likelier_branch_is_taken_though_the_search_begins_in_the_other() -> None:
    """Simulation 1: where all is as measured e_m lies below 0, a part of negligible weight."""
    scene, truth = _simulated(1)
    where = modes.ModeSearch(scene, 0).on(DEFAULT_RUNG, Coordinates.DEVIATES)
    assert not where.faults
    assert truth["e_m"] == pytest.approx(0.76, abs=0.01)
    assert where.found[0].mode.values["e_m"] > 0.5
    assert where.found[0].mode.weight > 0.99


@pytest.mark.slow
def test_parts_about_each_mode_make_up_the_posterior() -> None:
    """Simulation 6: the force alone may have turned B either way against A.

    Against populations tempered from the prior, which do not know the modes.
    """
    scene, _ = _simulated(6)
    where = modes.ModeSearch(scene, 0).on(DEFAULT_RUNG, Coordinates.DEVIATES)
    assert len(where.found) > 1
    drawn = [
        METHODS["importance"].draw(Task(each.posterior, 4, 2000, 0, 0, lambda *_: None))
        for each in where.found
    ]
    assert not any(each.faults for each in drawn)
    whole = from_the_prior(scene, DEFAULT_RUNG)
    sure = METHODS["smc"].draw(Task(whole, 16, 2000, 0, 1, lambda *_: None))
    evidence = np.array([each.attributes["log_evidence"] for each in drawn])
    total, error = float(logsumexp(evidence)), sure.attributes["log_evidence_sd"]
    assert error < 0.25
    assert total == pytest.approx(sure.attributes["log_evidence"], abs=4 * error)
    weights = np.exp(evidence - total)
    known = {k: np.asarray(v).reshape(16, -1) for k, v in sure.known(whole).items()}
    for name, above in (("speed_b", 13.5), ("e_m", 0.2)):
        values = [each.quantities[name] for each in drawn]
        share = sum(w * (v > above).mean() for w, v in zip(weights, values, strict=True))
        shares = (known[name] > above).mean(axis=1)
        assert share == pytest.approx(shares.mean(), abs=4 * shares.std(ddof=1) / 4), name
        assert shares.std(ddof=1) / 4 < 0.03, name


def turned_scene() -> Scene:
    """B turned twice and a bit; its rest heading alone also fits thrice, with less weight.

    Parts interlock, for the paper's mu is beyond the one that ends the sliding.
    """
    heading = SCENE.rest["b"].heading
    wrapped = replace(heading, value=heading.value - 4 * np.pi)
    rest = SCENE.rest | {"b": replace(SCENE.rest["b"], heading=wrapped, turns_known=False)}
    return replace(SCENE, rest=rest, contact=replace(SCENE.contact, interlocked=True))


@pytest.mark.slow
def test_chains_are_not_asked_where_modes_share_a_density() -> None:
    scene, truth = _simulated(6)
    found = reconstruct(scene, RunOptions(), pictured=False)
    assert found.checks.passed, found.checks.reasons
    assert found.settings["method"] == "importance"
    assert "nuts, was not accepted (the posterior has several modes" in found.notes[0]
    assert len(found.modes) > 1
    low, high = np.quantile(found.idata["posterior"]["speed_b"], [0.005, 0.995])
    assert low < truth["speed_b"] < high


@pytest.mark.slow
@pytest.mark.parametrize("method", ["nuts", "smc"])
def test_chains_and_populations_see_one_of_two_modes(method: str, two_normals: Posterior) -> None:
    """Why a other is a fault: chains, or populations, agree with one another."""
    task = Task(two_normals, 4, 300, 150, 0, lambda *_: None)
    assert (METHODS[method].draw(task).w[..., 0] < APART / 2).all()


def test_programs_of_the_other_rungs_are_unloaded() -> None:
    search, unloaded = modes.ModeSearch(SCENE, 0), []
    for rung in ("low", "full"):
        programs = SimpleNamespace(unload=partial(unloaded.append, rung))
        solution = SimpleNamespace(posterior=SimpleNamespace(programs=programs))
        search._found[rung, False, False] = modes.PosteriorModes([solution], ())
    search.unload_others("full")
    assert unloaded == ["low"]


def test_evidence_of_a_known_density(two_normals: Posterior) -> None:
    """Of two normals, unnormalised: (2 pi)^(n/2), of which tails may miss the second, SHARE of it."""
    found = log_evidence(two_normals, np.random.default_rng(0))
    n = two_normals.size
    whole = n / 2 * np.log(2 * np.pi)
    assert whole + np.log(1 - SHARE) - 0.1 < found.value < whole + 0.1
    assert 0 < found.error < 0.3


def test_a_mixture_takes_draws_as_their_weights_ask() -> None:
    trees, weights = [], (0.8, 0.2)
    for i, steps in enumerate((48, 96)):
        at = np.full((4, 500), float(i))
        draws = xr.Dataset({"x": (("chain", "draw"), at + np.arange(500))})
        predicted = xr.Dataset({"rest_heading_b": (("chain", "draw"), 2 * np.pi * at)})
        paths = xr.Dataset({"path": (("run", "step"), np.full((60, steps), i))})
        groups = {"posterior": draws, "posterior_predictive": predicted, "trajectories": paths}
        likelihood = xr.Dataset({"rest_heading_b": (("chain", "draw"), at)})
        groups |= {"log_likelihood": likelihood, "sample_stats": draws, "prior": draws}
        trees.append(xr.DataTree.from_dict(groups))
    found = [Mode(w, 0.0, {}, {"b": i}) for i, w in enumerate(weights)]
    mixed = modes.mixed(trees, found, seed=0)
    label = mixed["sample_stats"]["mode"].values
    assert label.mean() == pytest.approx(0.2, abs=4 * np.sqrt(0.16 / 2000))
    # each draw keeps its place in the chain, and its heading is counted as the first one's
    np.testing.assert_array_equal(mixed["posterior"]["x"], label + np.arange(500))
    np.testing.assert_allclose(mixed["posterior_predictive"]["rest_heading_b"], 0, atol=1e-12)
    np.testing.assert_array_equal(mixed["log_likelihood"]["rest_heading_b"], label)
    assert set(np.unique(mixed["trajectories"]["path"])) == {0, 1}
    assert mixed["trajectories"].sizes["step"] == 48
    for tree in trees:  # as of a method without statistics of its draws
        tree["sample_stats"] = xr.DataTree()
    assert (modes.mixed(trees, found, seed=0)["sample_stats"]["mode"].values == label).all()


@pytest.mark.slow
def test_unknown_turns_are_mixed_by_their_evidence() -> None:
    found = reconstruct(turned_scene(), RunOptions(method="importance", draws=1000))
    # the second has nearly the weight above the 95 % limit of e: chance says which e that is
    (reason,) = found.checks.reasons
    assert reason.startswith("restitution e: Monte Carlo error")
    label = found.idata["sample_stats"]["mode"].values
    first, second = found.modes[:2]
    assert found.scene.rest["b"].heading.value == pytest.approx(SCENE.rest["b"].heading.value)
    assert (first.turns, second.turns) == ({"b": 2}, {"b": 3})
    assert sum(m.weight for m in found.modes) == pytest.approx(1)
    assert second.weight > 1e-3
    assert (label == 1).mean() == pytest.approx(second.weight, abs=5e-3)
    spin = found.idata["posterior"]["Omega_b"].values
    assert spin[label == 1].min() > spin[label == 0].mean()  # a turn more asks for more spin
    predicted = by_item(found.idata, "posterior_predictive")["rest_heading_b"].values
    assert abs(predicted - SCENE.rest["b"].heading.value).max() < np.pi
    assert "B +743 deg" in next(note for note in found.notes if "several ways" in note)
