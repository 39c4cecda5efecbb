"""What a scene asks, and what is believed of the unknowns before: question, priors, coefficients."""

from __future__ import annotations

from collections.abc import Mapping

from retrodict.scene.entries.impact import ImpactEntry
from retrodict.scene.estimates import Complain
from retrodict.scene.fields import COEFFICIENTS
from retrodict.scene.measured import Measured
from retrodict.scene.priors import FIXED, Prior, default_priors, fixed_of, of_family, overridden
from retrodict.scene.quantities import UNKNOWNS
from retrodict.scene.schema import SceneEntry
from retrodict.scene.unwritten import OF_CONTACT


def question_of(
    entry: SceneEntry,
    priors: Mapping[str, Prior],
    unwritten: tuple[str, ...],
    complain: Complain,
) -> tuple[str, ...]:
    """The unknowns that a scene asks for: those that its file names, or all that are unknown."""
    fixed = fixed_of(priors)
    if wrong := [name for name in entry.question if name in fixed]:
        complain(
            "question", f"{wrong[0]} is fixed by its prior, so that nothing is asked; leave it out"
        )
    of_a = entry.vehicles.A.approach
    speed_is_known = bool(of_a.speed or of_a.speed_record)
    if entry.alone:
        return ("speed_a",)
    not_asked = {"speed_a" if speed_is_known else "", *fixed}
    not_asked |= {"speed_b"} if entry.vehicles.B is None else set()
    lacks = [key for key in unwritten if key.rpartition(".")[2] in OF_CONTACT]
    if wrong := [name for name in entry.question if name in COEFFICIENTS]:
        for key in lacks:
            fix = OF_CONTACT[key.rpartition(".")[2]]
            complain(key, f"missing; write {fix}, without which {wrong[0]} has no meaning")
        if entry.impact.together is True:
            why = f"vehicles that go on together leave no {wrong[0]} to ask for"
            complain("question", f"{why}; leave it out, or impact.together")
    not_asked |= set(COEFFICIENTS) if lacks or entry.impact.together else set()
    asked = entry.question or tuple(name for name in UNKNOWNS if name not in not_asked)
    if not asked:
        complain(
            "priors", "nothing is left to ask: every unknown is fixed; leave one of the priors out"
        )
    return asked


def coefficients_of(entry: ImpactEntry) -> dict[str, Measured]:
    """Coefficients of the impact that are written, by key; an exact one is a prior."""
    return {k: m for k in COEFFICIENTS if (m := getattr(entry, k)) is not None}


def priors_of(entry: SceneEntry, complain: Complain) -> dict[str, Prior]:
    """The default priors with those that are written in their place; exact coefficients are fixed."""
    priors = default_priors()
    for name, written in entry.priors:
        if written is not None:
            numbers = {key: m for key, m in written if isinstance(m, Measured)}
            sources = [written.source, *(m.source for m in numbers.values() if m.source)]
            values = {key: m.value for key, m in numbers.items()}
            family, source = getattr(written, "family", None), "; ".join(sources)
            priors[name] = (
                of_family(name, family, values, source)
                if family
                else overridden(name, values, source)
            )
    for v, each in entry.vehicles.by_letter.items():
        approach = each.approach
        if (approach.speed or approach.speed_record) and priors[f"speed_{v.lower()}"].family:
            key = f"vehicles.{v}.approach.speed"
            complain(f"priors.speed_{v.lower()}", f"{key} is measured; leave one of them out")
    for name, measured in coefficients_of(entry.impact).items():
        if priors[name].fixed or (measured.sd == 0 and priors[name].overridden):
            complain(f"impact.{name}", f"priors.{name} is written too; keep one of them")
        if measured.sd == 0:
            source = measured.source or f"impact.{name}, written without an uncertainty"
            priors[name] = of_family(name, FIXED, {"value": measured.value}, source)
    return priors
