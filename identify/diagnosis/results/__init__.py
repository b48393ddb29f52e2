"""Results of a search: budget of the residual, remainders, standard deviations and evidence."""
