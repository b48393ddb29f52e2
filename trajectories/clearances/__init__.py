"""Collision and region constraints."""
