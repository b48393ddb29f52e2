"""Simulated arms of two types, a check run a week, wear in some of them; what `exidyn fleet` makes of it."""
