"""Wrong input is told from missing physics."""
