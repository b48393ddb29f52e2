"""The arm with its findings: models, and simulations of its runs."""
