"""Where something is missing and of what class it is, without a law for it."""
