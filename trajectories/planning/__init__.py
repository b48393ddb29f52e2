"""Planning: a model and wishes come in, a plan goes out that a recorder can run."""
