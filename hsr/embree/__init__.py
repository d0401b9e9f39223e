"""Embree's library, and the packets of rays that go through it."""
