"""Run recording on a robot cell, and the `exidyn` command that ties the packages together."""
