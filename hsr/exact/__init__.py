"""The oracle: the owner of every sample, decided by exact arithmetic."""
