"""Renderers with classic mistakes planted in them."""
