"""Runs as they go on, recordings, plans, fits and diagnoses in Rerun, one layout a kind."""
