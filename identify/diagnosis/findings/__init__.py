"""Findings, numbers with units, and what is known of each kind of effect."""
