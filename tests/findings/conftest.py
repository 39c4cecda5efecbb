"""The made-up reconstructions of the report's tests."""

from tests.report.conftest import asked, drop, failing, outcome, rolled, sparse

__all__ = ["asked", "drop", "failing", "outcome", "rolled", "sparse"]
