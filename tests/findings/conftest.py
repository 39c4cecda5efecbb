"""The made-up reconstructions of the report's tests."""

from tests.report.conftest import drop, failing, outcome, rolled, sparse

__all__ = ["drop", "failing", "outcome", "rolled", "sparse"]
