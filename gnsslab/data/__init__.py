"""Registry of data sets: download, checksum, mirror."""

from gnsslab.data.fetching import DataUnavailable, dataset_path, fetch, verify
from gnsslab.data.registry import DataFile, Dataset, find_dataset, read_registry

__all__ = ["DataFile", "DataUnavailable", "Dataset", "dataset_path", "fetch", "find_dataset", "read_registry", "verify"]
