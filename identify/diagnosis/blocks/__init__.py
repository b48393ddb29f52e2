"""Blocks of runs, each left out and predicted by the others."""
