"""What drivers on a CAN bus share."""
