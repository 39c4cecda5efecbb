"""What a reconstruction comes to: every number, sentence and table of a report, computed once.

`of` makes the record; `summary.json` is its serialisation, and terminal, documents and figures print it.
"""

from retrodict.findings.record import Findings, of

__all__ = ["Findings", "of"]
