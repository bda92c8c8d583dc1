"""Meshcat scenes of flexmodal robots: postures, deflections, modes, and self-contained pages."""
