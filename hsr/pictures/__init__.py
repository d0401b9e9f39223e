"""Arrays in, pictures out: small PNG files, their colours, charts, and what a notebook shows."""
