"""Forward selection: what is added, compared with what, and how it is decided."""
