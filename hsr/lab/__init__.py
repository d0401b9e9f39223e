"""Experiments: what the methods cost, and where they break."""
