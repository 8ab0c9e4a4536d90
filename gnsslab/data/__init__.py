"""Registry of data sets: download, checksum, mirror."""
