"""From recordings to a robot arm's dynamics."""
