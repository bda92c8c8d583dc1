"""What is hidden in a campaign: asked for or drawn, where it sits, and how strong it has to be."""
