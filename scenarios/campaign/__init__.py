"""Campaigns: many seeded variations of a scenario on Dask, their results as Parquet, and what they say."""
