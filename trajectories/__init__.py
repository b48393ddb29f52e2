"""Trajectories for identification."""
