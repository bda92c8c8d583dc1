"""Modal analysis of flexible-joint robots."""
