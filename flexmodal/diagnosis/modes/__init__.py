"""Diagnosis from modes alone: natural frequencies, damping ratios and shapes of several postures."""
