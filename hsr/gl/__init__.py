"""Headless OpenGL contexts, each proven by drawing before it is used."""
