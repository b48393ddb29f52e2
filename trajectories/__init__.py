"""Motions for identification."""
