"""What was tested, as a `campaign.toml` says it."""
