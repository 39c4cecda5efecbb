"""What a reconstruction comes to: every number, sentence and table of a report, computed once.

`compute` makes the record; `summary.json` is its serialisation; terminal, documents and figures show it.
"""

from retrodict.findings.record import Findings, compute

__all__ = ["Findings", "compute"]
