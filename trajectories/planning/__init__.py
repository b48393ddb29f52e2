"""Planning: from a model and planning options to a plan that a recorder can run."""
