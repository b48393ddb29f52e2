"""Common part of drivers of servos on a serial port."""
