"""What is stored. Importing this package declares every table on `METADATA`."""

from data_schema.tables import design, equipment, files, hashes, people, results, runs, signals
from data_schema.tables.base import METADATA

__all__ = ["METADATA", "design", "equipment", "files", "hashes", "people", "results", "runs", "signals"]
