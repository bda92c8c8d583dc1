"""Blows integrated in time: for torques that depend on how far a joint swings, and what records cut off."""
