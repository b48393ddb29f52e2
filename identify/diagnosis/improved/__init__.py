"""The arm with what was found: models, and simulations of its runs."""
