"""The `retrodict` command: an interrupt before it has begun is reported in one line too."""

from __future__ import annotations

import os
import sys


def main() -> None:
    """Run the command that was typed; its exit status is the process's."""
    # XLA would write to the terminal that a compilation is slow; its errors are raised all the same
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    for stream in (sys.stdout, sys.stderr):
        if reconfigure := getattr(stream, "reconfigure", None):
            reconfigure(errors="replace")  # of an encoding that lacks a character
    try:
        from retrodict.cli import app
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(130)
    app()


if __name__ == "__main__":
    main()
