"""Checksums: what says that a file is the one that is meant."""

import hashlib


def sha256_of(path):
    """Return the sha256 of a file as hexadecimal text."""
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
