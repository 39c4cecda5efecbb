"""The study of crashes at random sees what is wrong, and goes on where it stopped."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.atlas.reconstructions import (
    APPROXIMATE,
    COLUMNS,
    EXACT,
    NUMBERS,
    apart,
    remarks,
    study,
)


def table(**changed: Any) -> pd.DataFrame:
    """Three crashes on which all methods agree; `changed` is of nuts in the second."""
    sound = dict.fromkeys(NUMBERS, 1.0) | {n: 0.01 for n in NUMBERS if n.endswith("error")}
    sound |= {"state": "passed", "why": "", "seconds": 1.0, "truth": 9.0, "low": 8.0, "high": 10.0}
    rows = [
        {"seed": seed, "method": method, "by": method, **sound}
        | (changed if (seed, method) == (1, "nuts") else {})
        for seed in range(3)
        for method in (*EXACT, *APPROXIMATE)
    ]
    return pd.DataFrame(rows, columns=COLUMNS)


def summary_of(**changed: Any) -> str:
    return "\n".join(text for _, text in remarks(table(**changed)))


def test_agreement_is_no_finding() -> None:
    assert "nuts, 3 crashes: 3 passed, 0 withheld" in summary_of()
    assert "those passed 0 have" in summary_of()
    assert "3 passed by itself (ordinary 2 of 2, slow 1 of 1)" in summary_of()
    assert "2 passed by itself (ordinary 1 of 2, slow 1 of 1)" in summary_of(by="importance")
    assert "errors apart in 0 " in summary_of()
    assert "| laplace | 3 | 0 | 0 | 0 |" in summary_of()


def test_a_truth_missed_a_disagreement_and_a_wrong_approximation_are_reported() -> None:
    assert "those passed 1 have" in summary_of(truth=10.1)
    assert "errors apart in 1 " in summary_of(**{"e mean": 1.06})
    assert "seeds 1" in summary_of(**{"e mean": 1.06})
    assert apart(table(**{"e mean": 1.06})) == [1]
    assert "errors apart in 0 " in summary_of(**{"e mean": 1.05})  # 3.5 of both errors together
    assert "would be wrong, apart in 0; the most 0.05" in summary_of(**{"e mean": 1.05})
    assert "would be wrong, apart in 1; the most 0.30" in summary_of(**{"e mean": 1.30})
    assert "| linear | 2 | 0 | 0 | 1 |" in summary_of(**{"mu mean": 1.3})


def test_methods_that_did_not_both_pass_are_not_compared() -> None:
    off = {"e mean": 2.0}
    assert "errors apart in 1 " in summary_of(**off)
    assert "errors apart in 0 " in summary_of(**off, state="withheld")
    assert "errors apart in 0 " in summary_of(**off, by="importance")


def test_a_study_keeps_what_was_done(tmp_path: Path) -> None:
    file = tmp_path / "table.csv"
    done = table()
    file.write_text(done.to_csv(index=False) + "# reconstructions: of an earlier run\n", "utf-8")
    pd.testing.assert_frame_equal(study(file, range(3)), pd.read_csv(file))
    assert len(pd.read_csv(file)) == len(done)
