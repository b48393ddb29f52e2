"""One start of a search: objectives, bounds and a start come in, the best coefficients go out."""
