"""Receptance of many systems at many frequencies: one algebra, written for numpy and for the compiler."""
