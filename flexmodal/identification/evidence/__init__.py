"""What a measurement says of a model: FRFs, modes, or both, behind one interface."""
