"""Findings, quantities with units, and the properties of each kind of effect."""
