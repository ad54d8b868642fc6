"""Makes `python -m companion` the same as `companion`."""

from companion.cli import main

main()
