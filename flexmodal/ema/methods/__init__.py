"""The methods of modal estimation, and what they share: peaks, basis functions, weights, covariances."""
