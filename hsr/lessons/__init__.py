"""Lessons: recordings of the real algorithms at work, line by line, on pictures of a few samples."""
