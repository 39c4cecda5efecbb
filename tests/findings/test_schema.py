"""The JSON schema of `summary.json` is that of the code, and summaries are as it says."""

from pathlib import Path

import pytest
from pydantic import TypeAdapter

from retrodict.findings import compute
from retrodict.findings.schema import Summary, json_schema
from retrodict.findings.summary import summarise
from tests.studies.made_up import ladder_of, step

FILE = Path(__file__).parents[2] / "docs" / "summary.schema.json"


def test_the_file_is_the_code_s():
    command = "python -m retrodict.findings.schema > docs/summary.schema.json"
    assert FILE.read_text("utf-8") == json_schema(), f"make it anew: {command}"


@pytest.mark.parametrize(
    "name",
    [
        "outcome",
        *(pytest.param(n, marks=pytest.mark.slow) for n in ("sparse", "rolled")),
        "failing",
        "asked",
    ],
)
def test_a_summary_is_as_the_schema_says(name, request):
    ladder = ladder_of(step("low", 21.0, 0.9), step("full", 19.0))
    found = summarise(compute(request.getfixturevalue(name), ladder))
    # what the schema does not know is left out of what it reads
    assert TypeAdapter(Summary).validate_python(found, strict=True) == found


def test_a_summary_without_draws_is_as_the_schema_says(outcome, drop):
    found = summarise(compute(drop(outcome, "posterior")))
    assert TypeAdapter(Summary).validate_python(found, strict=True) == found
