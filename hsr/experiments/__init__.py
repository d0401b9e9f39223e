"""Experiments on many methods: speed against error, and how both grow with the scene."""
