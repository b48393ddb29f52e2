"""Robot controllers, one file a driver."""
