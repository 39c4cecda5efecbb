"""A session without inference: B is as fast as A, by draws that are normal; and the page of it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from retrodict.explore.beside import outcome_of
from retrodict.explore.explorer import Explorer, Setting
from retrodict.explore.server import address, listen, serve
from retrodict.findings.answers import Answered
from retrodict.findings.questions import probability_of
from retrodict.inference.outcome import Checks
from retrodict.progress import Progress
from retrodict.scene import Scene, parse_scene
from retrodict.scene.asked import read_proposition
from retrodict.scene.measured import Measured
from retrodict.scene.quantities import Units, label_and_unit

BRACH = Path(__file__).parents[2] / "examples" / "brach-1977" / "scene.toml"
HOSTILE = "</script><img src=x onerror='window.ran=1'><b>bold</b>"
REFUSED, DOUBTFUL = 60.0, 3.0  # mph of A: no answer above; an uncertainty that fails the checks
MPH = 0.44704
_UNKNOWN = Measured(20.0, 0.9)


def hostile_scene() -> Scene:
    """A scene whose texts are markup."""
    text = BRACH.read_text("utf-8")
    lines = [
        f'title = "{HOSTILE}"'
        if line.startswith("title")
        else f'name = "{HOSTILE}"'
        if line.startswith("name")
        else line
        for line in text.splitlines()
    ]
    return parse_scene("\n".join(lines), "hostile")


@dataclass
class MadeUpAnswer:
    """Normal about A's speed."""

    scene: Scene
    model: str
    seconds: float = 0.01

    @property
    def checks(self) -> Checks:
        speed = self.scene.approach["a"].speed or _UNKNOWN
        if speed.sd > DOUBTFUL * MPH:
            reason = f"Pareto k is 0.90 (limit 0.7). {HOSTILE}"
            return Checks(None, np.nan, 90.0, 80.0, False, (reason,), ("speed_b",), pareto_k=0.9)
        return Checks(None, np.nan, 2000.0, 1800.0, True, flags=("energy is gained",), pareto_k=0.1)

    @property
    def draws(self) -> dict[str, np.ndarray]:
        rng = np.random.default_rng(0)
        speed = self.scene.approach["a"].speed or _UNKNOWN
        middle = {"speed_b": speed.value, "e": 0.1, "e_m": 0.7, "mu": 0.3}
        return {name: rng.normal(at, 0.05 * at, 1000) for name, at in middle.items()}

    def probability(self, proposition: str) -> Answered:
        return probability_of(outcome_of(self), {}, read_proposition(proposition))

    def summary(self, units: Units = "si") -> pd.DataFrame:
        rows = {}
        for name, values in self.draws.items():
            _, unit = label_and_unit(name, units)
            low, median, high = np.quantile(values, [0.025, 0.5, 0.975])
            numbers = {
                "mean": values.mean(),
                "sd": values.std(),
                "median": median,
                "low_95": low,
                "high_95": high,
                "mcse_mean": values.std() / 40,
            }
            scaled = {key: value / unit.worth for key, value in numbers.items()}
            rows[name] = {"unit": unit.symbol, **scaled, "checks": "passed"}
        return pd.DataFrame.from_dict(rows, orient="index")


@dataclass
class MadeUpResult:
    """Writes a report of one line."""

    def save(self, directory: Path, units: Units = "si") -> Path:
        directory.mkdir(parents=True, exist_ok=True)
        (directory / "report.html").write_text("<p>The report.</p>")
        return directory

    def archive(self, path: Path) -> Path:
        path.write_text("The archive.")
        return path


@dataclass
class MadeUpSession:
    """Answers at once, unless it is made to wait.

    Args:
        scene: that is answered.
        model: name of the rung.
        wait: called before each answer.
        asked: scenes that were answered.
    """

    scene: Scene
    model: str
    wait: Callable[[], object] = lambda: None
    asked: list[Scene] = field(default_factory=list)

    @property
    def answer(self) -> MadeUpAnswer:
        return MadeUpAnswer(self.scene, self.model)

    def update(self, changes: Scene) -> MadeUpAnswer:
        self.asked.append(changes)
        self.wait()
        speed = changes.approach["a"].speed or _UNKNOWN
        if speed.value > REFUSED * MPH:
            raise ValueError(f"no motion leads there {HOSTILE}")
        self.scene = changes
        return self.answer

    def confirm(self, *, progress: Progress) -> MadeUpResult:
        progress("sampling", 1, 2)
        return MadeUpResult()


def main() -> None:
    """Serve the page of the hostile scene, with results and scenes in a folder."""
    folder = Path(sys.argv[1])
    scene = hostile_scene()
    listening = listen(0)
    print(address(listening), flush=True)
    (folder / "scene.toml").write_text(scene.text)
    setting = Setting(("planar+spin",), folder / "out", folder / "scene.toml")
    with suppress(KeyboardInterrupt):
        serve(Explorer(scene, lambda of, by, _: MadeUpSession(of, by)), setting, listening)


if __name__ == "__main__":
    main()
