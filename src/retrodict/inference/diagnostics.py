"""Diagnostics of draws: which numbers are reliable, and which warnings about the scene go with them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from retrodict.inference.digits import decimals_of, monte_carlo_error, rhat_text
from retrodict.inference.misfit import MIN_PROBABILITY, UNEXPLAINED, UNSUPPORTED, misfit
from retrodict.inference.outcome import Checks
from retrodict.inference.pointwise import by_item
from retrodict.inference.prior_check import Reference, refuted
from retrodict.inference.samplers.psis import effective
from retrodict.scene.plausibility import plausibility_warnings
from retrodict.scene.quantities import SYSTEMS, describe, unit_of
from retrodict.scene.records import Scene

if TYPE_CHECKING:
    import xarray as xr

MAX_RHAT = 1.01
MIN_ESS = 400.0
MIN_BFMI = 0.3
_BEYOND = 2.5  # scales of the prior of e, beyond which the tests that it is from have nothing
_CENTRAL = 1.96  # scales of a half-normal that hold 95 %
_SURPRISE = 2.5  # standard deviations from what was measured
_LITTLE = 0.1  # share of the prior's crashes that weakly informative evidence leaves at least
_OFTEN = 0.01  # share of draws from which on an unusual outcome is flagged
_NONE = np.zeros(0)
_ROUNDING = 1e-6  # tolerance over the critical mu, where sliding just ends


def judge(
    idata: xr.DataTree,
    scene: Scene,
    reasons: tuple[str, ...] = (),
    reference: Reference | None = None,
) -> Checks:
    """Check draws (Vehtari et al. 2021: R-hat, bulk and tail ESS; Betancourt 2016: E-BFMI).

    A number is printed to the last digit whose unit is above its Monte Carlo error; a quantity fails
    where that leaves no digit of its standard deviation.

    Args:
        idata: draws, with groups posterior, posterior_predictive and sample_stats; and
            sample_stats_prior, where the prior was drawn.
        scene: scene with the measurements.
        reasons: faults already known; any makes the verdict negative.
        reference: crashes of the prior, with which the draws have to agree; None for no comparison.

    Returns:
        The verdict, with one sentence for each check that failed.
    """
    import arviz_stats  # slow to import; `reconstruct` does it while programs compile

    everything = idata["posterior"].to_dataset()
    # a simpler model infers fewer
    names = [name for name in scene.reported() if name in everything]
    posterior = everything[names]
    stats = idata["sample_stats"].to_dataset()
    divergences = int(stats["diverging"].sum()) if "diverging" in stats else None
    rhat = _by_name(arviz_stats.rhat(posterior))
    bulk = _by_name(arviz_stats.ess(posterior, method="bulk"))
    tail = _by_name(arviz_stats.ess(posterior, method="tail"))
    sd, error = _by_name(posterior.std(ddof=1)), _by_name(monte_carlo_error(posterior, 0.95))
    bfmi = _bfmi(np.asarray(stats["energy"])) if "energy" in stats else None
    # R-hat compares chains; replicates of weighted draws differ by chance, as the sample size says
    chained = "log_weight" not in stats

    found = list(reasons)
    said: dict[str, tuple[float, str]] = {}  # how bad it is, and the sentence, of each that fails
    for name in names:
        faults = []
        if chained and not rhat[name] <= MAX_RHAT:
            faults.append(f"R-hat {rhat_text(rhat[name])} is above {MAX_RHAT}")
        if not bulk[name] >= MIN_ESS:
            faults.append(f"bulk effective sample size {bulk[name]:.0f} is below {MIN_ESS:.0f}")
        if not tail[name] >= MIN_ESS:
            faults.append(f"tail effective sample size {tail[name]:.0f} is below {MIN_ESS:.0f}")
        if _nothing_left(name, sd[name], error[name]):
            faults.append(
                f"Monte Carlo error {error[name]:.2g} leaves no digit of sd {sd[name]:.2g}"
            )
        if faults:
            least = np.nan_to_num(min(bulk[name], tail[name]))
            badness = max(np.nan_to_num(rhat[name], nan=np.inf) / MAX_RHAT, MIN_ESS / max(least, 1))
            said[name] = badness, f"{describe(name)[0]}: {', '.join(faults)}"
    failed = [*said]
    if said:
        others = f"; {len(said) - 1} more quantities fail likewise" if len(said) > 1 else ""
        found.append(f"{max(said.values())[1]}{others}")
    if divergences:
        found.append(f"{divergences} divergent transitions: part of the posterior may be missing")
    if bfmi is not None and not bfmi >= MIN_BFMI:
        found.append(f"E-BFMI {bfmi:.2f} is below {MIN_BFMI}: the energy was explored too slowly")
    if reference is not None:
        drawn = {name: np.asarray(posterior[name]) for name in names}
        for name, sentence in refuted(reference, drawn, bulk).items():
            failed.append(name)
            found.append(sentence)
    return Checks(
        divergences=divergences,
        pareto_k=stats.attrs.get("pareto_k"),
        max_rhat=max(rhat.values()),
        min_ess_bulk=min(bulk.values()),
        min_ess_tail=min(tail.values()),
        passed=not found,
        reasons=tuple(found),
        failed=tuple(failed),
        flags=flags(everything, by_item(idata, "posterior_predictive"), scene, _weights(idata)),
        imprecise=tuple(
            n for n in names if decimals_of(sd[n], 1, error[n]) != decimals_of(sd[n], 1)
        ),
    )


def _nothing_left(name: str, sd: float, error: float) -> bool:
    """Whether the standard deviation is printed as zero, in units of either kind."""
    for units in SYSTEMS:
        worth = unit_of(describe(name)[1], units).worth
        decimals = decimals_of(sd / worth, error=error / worth)
        if decimals is not None and round(sd / worth, decimals) == 0:
            return True
    return False


def _weights(idata: xr.DataTree) -> np.ndarray:
    """Likelihood weights of crashes of the prior, shape (any,); empty where none were drawn."""
    if "sample_stats_prior" not in idata.children:
        return _NONE
    return np.asarray(idata["sample_stats_prior"]["weight"]).ravel()


def _by_name(dataset: xr.Dataset) -> dict[str, float]:
    return {str(name): float(value) for name, value in dataset.items()}


def _bfmi(energy: np.ndarray) -> float:
    """The smallest of the chains' E-BFMI."""
    if energy.shape[1] < 2:
        return float("nan")
    return float(np.min(np.mean(np.diff(energy, axis=1) ** 2, axis=1) / np.var(energy, axis=1)))


def flags(
    posterior: Mapping[Any, Any],
    predicted: Mapping[Any, Any],
    scene: Scene,
    weights: np.ndarray = _NONE,
    *,
    noise: bool = True,
) -> tuple[str, ...]:
    """Findings about the scene: implausible values, odd physics, and what disagrees with the rest.

    Args:
        posterior: draws of the unknowns, of the inputs and of what follows from them, by name.
        predicted: draws of what each item of evidence would be measured as, by name.
        scene: scene with the measurements.
        weights: likelihood weights of crashes of the prior, shape (any,); empty where none were drawn.
        noise: whether the predictions include the measurement's own error.
    """

    def draws(name: str) -> np.ndarray:
        return np.asarray(posterior[name])

    found = [*plausibility_warnings(scene)]
    off = misfit(posterior, predicted, scene, noise=noise)
    if off.probability < MIN_PROBABILITY:
        found.append(
            f"{UNEXPLAINED}: the probability of so large a misfit is {off.probability:.1g} "
            f"(chi-square {off.chi_square:.0f}, {off.freedom:.0f} degrees of freedom)"
        )
    if {"e", "closing_speed"} <= set(posterior) and not scene.priors["e"].overridden:
        fast, slow, over = scene.priors["e"].numbers
        scale = fast + (slow - fast) * np.exp(-draws("closing_speed") / over)
        if np.median(draws("e") / scale) > _BEYOND:
            found.append(
                f"restitution e of about {np.median(draws('e')):.2f} {UNSUPPORTED} (95 % of its prior "
                f"below {_CENTRAL * np.median(scale):.2f}): the measurements may not belong to one "
                "impact, or one of them is wrong"
            )
    if not scene.alone and weights.any() and (kept := effective(weights) / weights.size) > _LITTLE:
        found.append(
            f"the post-impact measurements are weakly informative: they leave {kept:.0%} of crashes "
            "drawn from the priors and inputs, so that the answer is mostly what these assume"
        )
    found += _odd_physics(posterior)
    items = [(n, m, posterior[n]) for n, m in scene.inputs().items() if n in posterior and m.sd > 0]
    items += [(n, m, predicted[n]) for n, m in scene.evidence().items() if n in predicted]
    for name, m, each in items:
        shift = (float(each.mean()) - m.value) / m.sd
        if abs(shift) > _SURPRISE:
            found.append(
                f"{describe(name)[0]}: what was measured lies {abs(shift):.1f} standard deviations "
                f"{'below' if shift > 0 else 'above'} what everything else together says"
            )
    return tuple(found)


def _odd_physics(posterior: Mapping[Any, Any]) -> Iterator[str]:
    """Findings of draws in which the impact does what no contact can."""

    def share(holds: np.ndarray) -> float:
        return float(np.mean(holds))

    def draws(name: str) -> np.ndarray:
        return np.asarray(posterior[name])

    if "mu" in posterior:
        reversed_ = share(draws("mu") / draws("mu_critical") > 1 + _ROUNDING)
        if reversed_ > _OFTEN:
            yield (
                f"in {reversed_:.0%} of the draws μ exceeds its critical value, at which sliding along "
                "the contact line ends: the impulse reverses the sliding (SAE 770014, caution at eq 23)"
            )
    if "normal_impulse" in posterior and (pulled := share(draws("normal_impulse") < 0)) > _OFTEN:
        yield (
            f"in {pulled:.0%} of the draws the normal impulse holds the vehicles together, as no "
            "contact can"
        )
    if "energy_lost" in posterior and (gained := share(draws("energy_lost") < 0)) > _OFTEN:
        yield f"in {gained:.0%} of the draws the impact gains kinetic energy"
