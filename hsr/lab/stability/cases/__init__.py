"""The families, one a module: each has a ``FAMILY``."""
