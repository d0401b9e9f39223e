"""The exact problem and its answers: geometry, view, map."""
