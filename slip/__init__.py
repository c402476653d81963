"""Force sequences in, slip scores out."""
