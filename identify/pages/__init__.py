"""Documents of fits, diagnoses, comparisons and fleets, and their plots."""
