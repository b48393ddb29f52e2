"""Views: recordings, fits and diagnoses in Rerun, one layout a kind."""
