"""The live view of a run, in a process of its own."""
