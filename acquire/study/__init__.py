"""A study: run after run, each chosen by what the ones before left open, until the model is decided."""
