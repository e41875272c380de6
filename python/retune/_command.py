"""The command ``retune``: the same code as the binary, in this process."""

from __future__ import annotations

import signal
import sys
from typing import NoReturn

from . import _core


def main() -> NoReturn:
    """Performs the command line and ends with its exit code."""
    # Ctrl-C is for the command, which listens by itself; without a handler of its own a signal ends the process, as it does the binary.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    words = ["retune", *sys.argv[1:]]
    sys.exit(_core.command([sys.executable, "-m", "retune"], words))


if __name__ == "__main__":
    main()
