"""Franka Research 3 through the FCI: the maker's library in a process of its own, 1 kHz, joint positions."""
