"""Says what is still missing between a model and a measurement, and adds it."""
