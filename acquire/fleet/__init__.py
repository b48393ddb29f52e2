"""Recordings of many arms, ARM/….mcap, and what is kept of them: Parquet files, tables, a page."""
