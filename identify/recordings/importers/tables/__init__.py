"""From a `Table` of named columns, whatever file it is of, to a `Recording` in SI units."""
