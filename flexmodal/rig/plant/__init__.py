"""The robot on the rig as a structure: rigid links on flexible joints, and what effects add to it."""
