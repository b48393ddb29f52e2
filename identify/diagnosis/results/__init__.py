"""Results of a search: the budget of the misfit, what is left, deviations, evidence."""
