"""Views in Rerun of live runs, recordings, plans, fits and diagnoses, each with its own layout."""
