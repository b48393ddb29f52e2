"""KUKA's Robot Sensor Interface: its configuration file, its telegrams, and one session of them."""
