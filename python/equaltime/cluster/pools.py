"""Clusters of processes that an executor of Python's library runs: process pools, MPI pools, or any other."""

from __future__ import annotations
