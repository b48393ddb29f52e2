"""Reading and writing a `Recording` as an MCAP file, including files that were cut off."""
