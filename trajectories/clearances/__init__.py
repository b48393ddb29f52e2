"""Collisions and regions: what must keep clear of what."""
