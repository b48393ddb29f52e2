"""The search for the most informative series within all bounds."""
