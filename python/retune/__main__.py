"""``python -m retune`` is the command."""

from ._command import main

main()
