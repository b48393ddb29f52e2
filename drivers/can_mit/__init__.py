"""Motors with the MIT frame on CAN."""
