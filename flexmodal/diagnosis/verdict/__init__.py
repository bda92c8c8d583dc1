"""The answer in words, and what to measure next."""
