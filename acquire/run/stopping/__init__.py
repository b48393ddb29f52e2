"""What stops a run, and how hard."""
