"""Discrimination between models that all explain the data so far."""
