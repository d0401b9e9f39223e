"""The certified depth buffer: half-space tests on tiles."""
