"""Documents of fits, diagnoses and comparisons, and their plots."""
