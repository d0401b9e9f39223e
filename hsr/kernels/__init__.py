"""Numba kernels: numbers and arrays in and out, nothing of scenes or files."""
