"""Recording a run on a robot cell, and the `exidyn` command that ties the folders together."""
