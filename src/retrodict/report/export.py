"""A result as files of other programs: a format is one function and one line in `EXPORTS`."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from retrodict.findings.run_outs import motion_of, motions, place_of
from retrodict.findings.statistics import posterior_of
from retrodict.findings.stored import DRAWS as POSTERIOR
from retrodict.findings.stored import stored
from retrodict.findings.summary import summary_frame
from retrodict.inference.outcome import attributes_of
from retrodict.interchange.dxf_out import dxf
from retrodict.interchange.motion_csv import COLUMNS, UNITS, frame_times, motion_csv
from retrodict.interchange.parquet import parquet
from retrodict.interchange.svg_out import svg
from retrodict.interchange.tables import table_csv
from retrodict.report.blocks import Section, Table
from retrodict.report.content import content
from retrodict.report.libraries import imported
from retrodict.report.scene_layers import scene_drawing
from retrodict.scene.quantities import Units
from retrodict.storage.files import write_together

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome
    from retrodict.interchange.plan_drawing import Drawing

DRAWS = ("median", "5%", "95%")
_EXTRA = "interchange"
_TITLE = 80  # letters of a title in a file's name
_FASTEST, _LONGEST = 1000.0, 60.0  # frames a second; s


class NotExported(ValueError):
    """The export that was asked for is not possible; the message says what is."""


@dataclass(frozen=True, slots=True)
class Asked:
    """Options of an export.

    Args:
        draws: draws whose motion is exported, each as `which` of `motion_of`; at least one. Drawings
            show the first.
        rate: frame rate, frames per second.
        before: duration of the approach before the impact, s; rounded up to whole frames in motion
            files.
        units: "si" or "us", the system of units of the tables.
    """

    draws: tuple[str | int, ...] = DRAWS
    rate: float = 30.0
    before: float = 1.0
    units: Units = "si"


Files = dict[str, bytes]  # content of each file, by its path in the folder


def motion_files(findings: Findings, outcome: Outcome, asked: Asked) -> Files:
    """Motions, one CSV per vehicle and draw, and `motion.json`, which describes them."""
    found, files, entries = motions(outcome), Files(), []
    lead = math.ceil(round(asked.before * asked.rate, 6))
    impact = float(frame_times(asked.rate, lead + 1)[lead])
    for which in dict.fromkeys(asked.draws):
        motion = motion_of(found, which)
        # the last frame is at rest
        time = frame_times(asked.rate, lead + math.ceil(round(motion.lasts * asked.rate, 6)) + 1)
        names = {v: f"{v}-{_file_name(which)}.csv" for v in findings.scene.vehicles}
        for v, name in names.items():
            pose = motion.poses(v, time - impact)
            files[f"motion/{name}"] = motion_csv(time, pose)
        place = place_of(outcome, motion)
        entries.append(
            {
                "asked": str(which),
                "number": motion.number,
                "posterior": place and dict(zip(("chain", "draw"), place, strict=True)),
                "speed": motion.speed,
                "files": names,
            }
        )
    about = {
        "scene": findings.scene.title,
        "scene_sha256": findings.scene_text.sha256,
        "verdict": findings.verdict,
        "vehicles": {v: findings.scene.vehicles[v].name for v in findings.scene.vehicles},
        "point": "centre of gravity, on the road plane (Z = 0)",
        "units": dict(zip(COLUMNS, UNITS, strict=True)),
        "frame_rate": asked.rate,
        "impact_time": impact,
        "draws": entries,
    }
    text = json.dumps(about, indent=2, ensure_ascii=False, allow_nan=False)
    return files | {"motion/motion.json": f"{text}\n".encode()}


def dxf_file(findings: Findings, outcome: Outcome, asked: Asked) -> Files:
    """The scene from above as DXF."""
    imported("ezdxf", "a DXF file", _EXTRA)
    return {"scene.dxf": dxf(_drawing(findings, outcome, asked))}


def svg_file(findings: Findings, outcome: Outcome, asked: Asked) -> Files:
    """The scene from above as SVG, to scale."""
    return {"scene.svg": svg(_drawing(findings, outcome, asked))}


def table_files(findings: Findings, outcome: Outcome, asked: Asked) -> Files:
    """The results as numbers with all digits, and every table of the report as it is printed."""
    frame = summary_frame(findings, asked.units)
    numbers = [
        [None if isinstance(cell, float) and math.isnan(cell) else cell for cell in row]
        for row in frame.reset_index().to_numpy(dtype=object).tolist()
    ]
    files = {"tables/results.csv": table_csv(["quantity", *frame.columns], numbers)}
    for section in content(findings, {}, {}, asked.units).sections:
        for name, table in _tables(section):
            files[f"tables/{name}.csv"] = table_csv(table.header, table.rows)
    return files


def netcdf_file(findings: Findings, outcome: Outcome, asked: Asked) -> Files:
    """All groups of draws as NetCDF, as a folder of results has them."""
    return {"draws.nc": stored(outcome)[POSTERIOR]}


def parquet_file(findings: Findings, outcome: Outcome, asked: Asked) -> Files:
    """The posterior draws as a Parquet table, in SI units and radians."""
    imported("pyarrow", "a Parquet file", _EXTRA)
    draws = posterior_of(outcome)
    if not draws.sizes:
        raise NotExported("the result has no draws; leave parquet out")
    rows = draws.stack(row=("chain", "draw"), create_index=False)
    columns = {str(name): np.asarray(values) for name, values in rows.variables.items()}
    attributes = {
        str(name): {key: str(values.attrs[key]) for key in ("unit", "label") if key in values.attrs}
        for name, values in rows.data_vars.items()
    }
    about = attributes_of(outcome) | {"verdict": findings.verdict}
    return {"draws.parquet": parquet(columns, attributes, about)}


Export = Callable[["Findings", "Outcome", Asked], Files]

EXPORTS: dict[str, Export] = {
    "motion": motion_files,
    "dxf": dxf_file,
    "svg": svg_file,
    "tables": table_files,
    "netcdf": netcdf_file,
    "parquet": parquet_file,
}


def checked(formats: Iterable[str], asked: Asked) -> list[str]:
    """The formats to export, once each.

    Args:
        formats: names of `EXPORTS`, in any case.
        asked: options of the export; its frame rate and approach are checked.

    Returns:
        Names of the formats; all of `EXPORTS` where `formats` is empty.

    Raises:
        NotExported: there is no such format, or frame rate or approach are out of range.
    """
    if not 0 < asked.rate <= _FASTEST:
        raise NotExported(
            f"{asked.rate:g} frames a second: write a rate above 0, {_FASTEST:g} at most"
        )
    if not 0 <= asked.before <= _LONGEST:
        raise NotExported(f"{asked.before:g} s before the impact: write 0 to {_LONGEST:g} s")
    wanted = list(dict.fromkeys(each.strip().lower() for each in formats))
    for each in wanted:
        if each not in EXPORTS:
            raise NotExported(f"no format {each[:40]!r} to export: choose of {', '.join(EXPORTS)}")
    return wanted or list(EXPORTS)


def write_export(
    findings: Findings,
    outcome: Outcome,
    folder: Path,
    formats: Iterable[str] = (),
    asked: Asked | None = None,
) -> list[Path]:
    """Write a result in formats of other programs, once all are made.

    Args:
        findings: findings of the reconstruction.
        outcome: outcome of the reconstruction, with its draws.
        folder: output folder, made where missing; files of the same names in it are replaced.
        formats: names of `EXPORTS`, in any case; all of them where empty.
        asked: options of the export; None for the defaults.

    Returns:
        The files.

    Raises:
        NotExported: there is no such format, there are no draws for it, or frame rate or approach are
            out of range.
        NoMotion: there is no such draw, or no motion is recorded.
        MissingLibrary: a format needs a library that is not installed.
        OSError: something could not be written; then nothing in the folder has changed.
    """
    asked = asked or Asked()
    files: Files = {}
    for each in checked(formats, asked):
        files |= EXPORTS[each](findings, outcome, asked)
    write_together(folder, files)
    return [folder / name for name in files]


def _drawing(findings: Findings, outcome: Outcome, asked: Asked) -> Drawing:
    return scene_drawing(findings, outcome, asked.draws[0], asked.before)


def _tables(section: Section) -> Iterator[tuple[str, Table]]:
    """The tables of a section and its parts, named after the section that they stand in."""
    own = [block for block in section.blocks if isinstance(block, Table)]
    for number, table in enumerate(own, start=1):
        last = table.title or (str(number) if number > 1 else "")
        yield _slug(f"{section.number} {section.title[:_TITLE]} {last}"), table
    for part in section.blocks:
        if isinstance(part, Section):
            yield from _tables(part)


def _file_name(which: str | int) -> str:
    text = str(which)
    return _slug(f"draw {text}" if text.isdecimal() else text.replace("%", " percent"))


def _slug(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")
