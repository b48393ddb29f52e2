"""Planning: from a model and planning options to a plan that a recorder can run, by a search or by a rule."""
