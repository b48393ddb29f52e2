"""Telling models apart that all explain the data so far."""
