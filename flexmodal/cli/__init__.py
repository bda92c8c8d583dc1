"""The command line: one file a command; parses and prints, computes nothing."""
