"""``python -m hsr.cli``."""

from hsr.cli import main

main()
