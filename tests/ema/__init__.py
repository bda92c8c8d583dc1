"""Measured FRFs to modes."""
