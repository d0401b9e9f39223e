"""What everything stands on: errors, names of arrays, whole files, the one Numba decorator."""
