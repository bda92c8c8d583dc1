"""The plant in time: exact steps where it is linear, Newton's method where it is not."""
