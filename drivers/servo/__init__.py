"""What drivers of servos on a serial port share."""
