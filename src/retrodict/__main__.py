"""The `retrodict` command: an interrupt before it has begun is reported in one line too."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command that was typed; its exit status is the process's."""
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
