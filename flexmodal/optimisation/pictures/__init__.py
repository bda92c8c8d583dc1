"""Pictures of a posture search: what it found, how it got there, and over the workspace."""
