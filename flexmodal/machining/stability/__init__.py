"""Stability of a cut: zero order, several harmonics, semi-discretisation, one direction, mode coupling."""
