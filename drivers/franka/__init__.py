"""Franka Research 3 through the FCI: the maker's library in a separate process, 1 kHz, joint positions."""
