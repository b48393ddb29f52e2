"""Tables of named columns, whatever file they come from.

In: a `Table` of a file format's reader, and where its columns differ from what is read by default.
Out: `Recording`, in SI units.
"""
