"""A car that strikes a wall, solved by hand: what each prior and item of evidence says, by quadrature.

The impact centre lies straight ahead and the wall's normal runs through the centre of gravity, so that
V_n = -e v_n, and sliding ends at mu_c = tan(angle) / ((1 + e) (1 + e_m m d² / I)).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import stats

from retrodict.scene.priors import of_family
from retrodict.scene.records import Approach, Barrier, Measured, Scene
from tests.shared.scenes import collision

MODEL = "planar-moment+spin"
ANGLE, LEVER = 0.6, 2.0  # direction of travel from the wall's normal, rad; impact centre ahead, m
CHANGE = Measured(-17.0, 1.0)  # of the velocity along the heading, m/s
COEFFICIENTS = {"e": Measured(0.2, 0.15), "e_m": Measured(0.6, 0.2), "mu": Measured(0.3, 0.06)}
_NODES, _WEIGHTS = (x / 2 for x in np.polynomial.legendre.leggauss(120))

Numbers = Mapping[str, float]
Priors = Mapping[str, tuple[str, Numbers]]
FAMILIES: dict[str, Priors] = {
    "normal": {
        "speed_a": ("normal", {"mean": 14.0, "sd": 4.0}),
        "e": ("normal", {"mean": 0.1, "sd": 0.2}),
        "e_m": ("normal", {"mean": 0.9, "sd": 0.4}),
        "mu": ("normal", {"mean": 0.3, "sd": 0.15}),
    },
    "lognormal": {
        "speed_a": ("lognormal", {"mean": 15.0, "sd": 5.0}),
        "e": ("lognormal", {"mean": 0.4, "sd": 0.4}),
        "e_m": ("lognormal", {"mean": 0.7, "sd": 0.3}),
        "mu": ("lognormal", {"mean": 0.4, "sd": 0.2}),
    },
    "uniform": {
        "speed_a": ("uniform", {"low": 12.0, "high": 18.0}),
        "e": ("uniform", {"low": 0.05, "high": 0.5}),
        "e_m": ("uniform", {"low": -0.5, "high": 0.7}),
        "mu": ("uniform", {"low": 0.25, "high": 0.6}),
    },
    "beta": {
        "speed_a": ("normal", {"mean": 14.0, "sd": 4.0}),
        "e": ("beta", {"alpha": 1.5, "beta": 6.0}),
        "e_m": ("beta", {"alpha": 4.0, "beta": 2.0}),
        "mu": ("beta", {"alpha": 3.0, "beta": 4.0}),
    },
    "fixed": {
        "speed_a": ("lognormal", {"mean": 15.0, "sd": 5.0}),
        "e": ("fixed", {"value": 0.15}),
        "e_m": ("uniform", {"low": 0.0, "high": 1.0}),
        "mu": ("fixed", {"value": 0.35}),
    },
    "fixed speed": {
        "speed_a": ("fixed", {"value": 16.0}),
        "e": ("uniform", {"low": 0.0, "high": 1.0}),
        "e_m": ("fixed", {"value": 0.8}),
        "mu": ("uniform", {"low": 0.1, "high": 0.9}),
    },
}
_CUT = {"speed_a": (0.0, math.inf), "e": (0.0, 1.0), "e_m": (-1.0, 1.0), "mu": (0.0, math.inf)}


def scene(priors: Priors, coefficients: Mapping[str, Measured] = COEFFICIENTS) -> Scene:
    """The scene with these priors; nothing in it but they and the evidence is uncertain."""
    plain = collision(share=0.0, berm=False)
    car = replace(
        plain.vehicles["a"],
        heading=Measured(0.0),
        impact_angle=Measured(0.0),
        impact_distance=Measured(LEVER),
    )
    fixed = {name for name, (family, _) in priors.items() if family == "fixed"}
    return replace(
        plain,
        vehicles={"a": car},
        approach={"a": Approach(None, Measured(ANGLE), Measured(0.0))},
        rest={},
        departure={"a": {"delta_v_forward": CHANGE}},
        contact=replace(plain.contact, Gamma=Measured(0.0)),
        barrier=Barrier("wall", "wall"),
        question=tuple(k for k in ("speed_a", "e", "e_m", "mu") if k not in fixed),
        coefficients={k: m for k, m in coefficients.items() if k not in fixed},
        priors=plain.priors
        | {k: of_family(k, family, numbers, "a test") for k, (family, numbers) in priors.items()},
    )


def law(name: str, family: str, numbers: Numbers) -> Callable[[np.ndarray], np.ndarray]:
    """Quantile of a prior by SciPy, cut at what is possible."""
    if family == "uniform":
        own = stats.uniform(numbers["low"], numbers["high"] - numbers["low"])
    elif family == "beta":
        own = stats.beta(numbers["alpha"], numbers["beta"])
    elif family == "normal":
        own = stats.norm(numbers["mean"], numbers["sd"])
    else:
        variance = math.log1p((numbers["sd"] / numbers["mean"]) ** 2)
        own = stats.lognorm(math.sqrt(variance), scale=numbers["mean"] * math.exp(-variance / 2))
    below, above = own.cdf(_CUT[name])
    return lambda p: own.ppf(below + p * (above - below))


@dataclass(frozen=True)
class Posterior:
    """Mean and standard deviation of each unknown by quadrature, and the evidence.

    Args:
        mean: posterior mean, by name.
        sd: posterior standard deviation, by name.
        evidence: prior mean of the likelihood.
    """

    mean: dict[str, float]
    sd: dict[str, float]
    evidence: float


def posterior(
    of: Scene, priors: Priors, of_speed: Callable[[np.ndarray], Any] = lambda v: 0.0
) -> Posterior:
    """The posterior of `scene` by Gauss-Legendre quadrature over probabilities of the priors.

    Args:
        of: the scene.
        priors: its priors.
        of_speed: a further log likelihood, of the speed, m/s.
    """
    points, weights = {}, {}
    for name, (family, numbers) in priors.items():
        fixed = family == "fixed"
        points[name] = np.array(
            [numbers["value"]] if fixed else law(name, family, numbers)(_NODES + 0.5)
        )
        weights[name] = np.ones(1) if fixed else _WEIGHTS
    v, e, e_m, f = (points[k] for k in ("speed_a", "e", "e_m", "mu"))

    def item(key: str, predicted: np.ndarray) -> np.ndarray:
        m = of.coefficients.get(key)
        return np.ones_like(predicted) if m is None else stats.norm(m.value, m.sd).pdf(predicted)

    change = stats.norm(CHANGE.value, CHANGE.sd).pdf(-(1 + e[:, None]) * v * math.cos(ANGLE))
    by_speed = change * np.exp(of_speed(v)) * weights["speed_a"]  # (e, v)
    car = of.vehicles["a"]
    ratio = e_m * car.mass.value * LEVER**2 / car.yaw_inertia.value
    critical = math.tan(ANGLE) / ((1 + e[:, None]) * (1 + ratio))
    mu = np.minimum(f, critical[..., None])  # (e, e_m, f)
    by_mu = item("mu", mu) * weights["mu"]
    of_e = item("e", e) * weights["e"]
    of_e_m = item("e_m", e_m) * weights["e_m"]
    joint = (of_e * by_speed.sum(1))[:, None, None] * of_e_m[:, None] * by_mu
    total = joint.sum()
    speeds = (of_e * (of_e_m[:, None] * by_mu).sum((1, 2))) @ by_speed / total
    marginals = {
        "speed_a": (v, speeds),
        "e": (e, joint.sum((1, 2)) / total),
        "e_m": (e_m, joint.sum((0, 2)) / total),
        "mu": (mu, joint / total),
    }
    mean = {k: float(np.sum(x * w)) for k, (x, w) in marginals.items()}
    square = {k: float(np.sum((x - mean[k]) ** 2 * w)) for k, (x, w) in marginals.items()}
    return Posterior(mean, {k: math.sqrt(x) for k, x in square.items()}, float(total))
