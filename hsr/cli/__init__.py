"""The command ``hsr``, one file a verb."""

from hsr.cli.app import main as main
