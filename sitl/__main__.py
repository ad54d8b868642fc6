"""`python -m sitl` is `sitl`."""

from sitl.cli import main

main()
