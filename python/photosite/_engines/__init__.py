"""Data sets on many processes and machines.

The driver, which is the caller's process, plans tasks and gives them to an engine: processes of this machine, Ray or
Dask. Workers make the pictures where the results go, a folder that all machines see or an object store, and answer with
what failed; pictures never pass through the driver.
"""
