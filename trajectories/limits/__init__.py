"""Limits of the joints, and checks of trajectories against them."""
