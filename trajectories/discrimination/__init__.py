"""Distinguishing models that all explain the data so far."""
