"""Recordings of many arms, ARM/….mcap, and their results: Parquet files, tables, a page."""
