"""Things tried side by side, on several cores of this machine."""
