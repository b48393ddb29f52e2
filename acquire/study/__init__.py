"""A study: a sequence of runs, each chosen to answer the questions that earlier runs left open."""
