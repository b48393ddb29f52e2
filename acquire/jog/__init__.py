"""Jog: one joint a little way and back, and what that tells of its sign, scale, gain and zero."""
