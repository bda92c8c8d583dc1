"""What to measure next, and what it is expected to tell."""
