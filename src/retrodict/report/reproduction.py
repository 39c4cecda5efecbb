"""The outcome of a replay, as lines of text."""

from __future__ import annotations

from typing import TYPE_CHECKING

from retrodict.findings.reproduction import SAMENESS

if TYPE_CHECKING:
    from retrodict.findings.reproduction import Reproduction

_MOST = 20  # numbers that are listed


def reproduction_lines(found: Reproduction) -> list[str]:
    """The verdict, how many numbers came out the same, those that did not, and possible reasons.

    Args:
        found: comparison of a repeated run with the recorded one.

    Returns:
        The lines, the verdict first.
    """
    verdict = "every number reproduced" if found.reproduced else "NOT every number reproduced"
    lines = [f"{found.title}: {verdict}", f"archive verified; its chain ends in {found.link}"]
    for sameness, words in SAMENESS.items():
        count = sum(each.sameness == sameness for each in found.numbers)
        if count or sameness == "bits":
            lines.append(f"{count} of {len(found.numbers)} numbers are {words}")
    other = [each for each in found.numbers if each.sameness in ("error", "no")]
    lines += [
        f"  {each.name}: {each.recorded} was recorded, now {each.again} ({SAMENESS[each.sameness]})"
        for each in other[:_MOST]
    ]
    if len(other) > _MOST:
        lines.append(f"  and {len(other) - _MOST} more")
    same = sum(found.draws.values())
    lines.append(f"{same} of {len(found.draws)} variables of the draws are the same to the bit")
    if found.versions:
        differ = (f"{name} {then} (now {now})" for name, (then, now) in found.versions.items())
        lines.append(f"other versions or platform: {', '.join(differ)}")
    elif not found.reproduced:
        lines.append("versions and platform are those recorded; processor or threads may differ")
    return lines
