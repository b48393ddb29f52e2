"""Robots that come with exidyn: one robot file each, read by its name."""
