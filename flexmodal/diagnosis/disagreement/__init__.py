"""Where a model and a measurement disagree, by how much, and of what kind the disagreement is."""
