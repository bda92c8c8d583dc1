"""Text files read safely, and their faults put into words; below cards and campaigns, which share it."""
