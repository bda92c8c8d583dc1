"""Blows marched in time, for torques that depend on how far a joint swings, and for what records cut off."""
