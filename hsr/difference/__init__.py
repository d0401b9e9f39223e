"""Where two visibility maps differ, and how."""
