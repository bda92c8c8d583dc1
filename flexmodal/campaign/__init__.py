"""Measured data, and the only door to Universal File Format files. Knows no robot."""

from flexmodal.campaign.uff import write_frf as write_frf
