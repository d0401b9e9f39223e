"""Coherent tiles of rays, certified."""
