"""Robots that come with exidyn."""
