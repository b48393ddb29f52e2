"""Conversion of a `Table` of named columns, from any file, to a `Recording` in SI units."""
