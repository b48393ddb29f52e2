"""What a motion shows of a model: unknowns and a motion come in, a number to make small goes out."""
