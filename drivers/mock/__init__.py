"""A simulated arm with drives, encoders and noise."""
