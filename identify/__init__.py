"""Identification of a robot arm's dynamics from recordings."""
