"""Hypotheses from many to a few: coarse looks, close fits, what might be added."""
