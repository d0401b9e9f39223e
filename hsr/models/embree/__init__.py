"""Embree, modelled stage by stage."""
