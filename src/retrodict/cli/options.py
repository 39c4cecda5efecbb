"""Options and arguments that commands share, and the words that they take."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class UnitChoice(StrEnum):
    """Units that results are given in."""

    si = "si"
    us = "us"


# spelled out, not taken from `inference.samplers`: that would import JAX for --help
MethodChoice = StrEnum(
    "MethodChoice", ["nuts", "importance", "smc", "laplace", "monte-carlo", "linear"]
)
AutoChoice = StrEnum(
    "AutoChoice", ["auto", "nuts", "importance", "smc", "laplace", "monte-carlo", "linear"]
)
ExactChoice = StrEnum("ExactChoice", ["importance", "nuts", "smc"])

SceneFile = Annotated[Path, typer.Argument(help="the scene file (TOML)", show_default=False)]
ResultFolder = Annotated[
    Path, typer.Argument(help="folder of a result, as reconstruct wrote it", show_default=False)
]
OutFolder = Annotated[
    Path | None, typer.Option(help="folder for the results [default: out/NAME-OF-THE-SCENE]")
]
ModelName = Annotated[
    str, typer.Option(help="a rung's name, or auto for the one that the ladder chooses")
]
Seed = Annotated[int, typer.Option(min=0, max=2**31 - 1, help="of every random number")]
ResultUnits = Annotated[UnitChoice, typer.Option(help="units of the results")]
Quiet = Annotated[bool, typer.Option("--quiet", help="print errors only")]
