"""URDF text to a checked tree of links and joints, without Pinocchio."""
