"""Common part of drivers on a CAN bus."""
