"""A folder of recordings of many arms, and what is kept of them.

In: a folder or fsspec address, ARM/….mcap; an executor.
Out: Parquet files by arm and month, a row a run; tables of values and changes; a page.
"""
