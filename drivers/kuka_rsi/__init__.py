"""KUKA's Robot Sensor Interface."""
