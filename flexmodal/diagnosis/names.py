"""Names of what is no effect of the catalogue."""

UNKNOWN = "unknown"
"""Name of an effect that the catalogue does not have."""
NONE, UNSTRUCTURED = "none", "unstructured_mode"
"""Names of the explanations that add no effect: the robot re-tuned, and one more mode with no structure."""
