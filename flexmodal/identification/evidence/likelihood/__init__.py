"""Likelihood of measured modes, scales of their scatter inferred along, and its integral."""
