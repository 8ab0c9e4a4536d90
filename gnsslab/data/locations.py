"""Where things lie: what travels with the project, the mirror, the user's cache."""

import os
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent


def project_folder(name):
    """Return the folder `lessons` or `datasets`: inside the package in an installed wheel, beside it in a checkout.

    >>> (project_folder("datasets") / "registry.toml").is_file()
    True
    """
    for folder in (PACKAGE / "share" / name, PACKAGE.parent / name):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"the folder {name!r} of gnsslab is missing beside {PACKAGE}: install gnsslab again")


def project_file(name):
    """Return a file that travels with the project, `pyproject.toml`: from an installed wheel or a checkout."""
    for file in (PACKAGE / "share" / name, PACKAGE.parent / name):
        if file.is_file():
            return file
    raise FileNotFoundError(f"the file {name!r} of gnsslab is missing beside {PACKAGE}: install gnsslab again")


def mirror_folder():
    """Return the folder named by GNSSLAB_DATA_MIRROR, or None where the variable is not set; raise where it names no folder."""
    name = os.environ.get("GNSSLAB_DATA_MIRROR")
    if not name:
        return None
    if not Path(name).is_dir():
        raise NotADirectoryError(f"GNSSLAB_DATA_MIRROR names {name}, which is no folder: correct it, or unset it to download")
    return Path(name)


def cache_folder():
    """Return the user's cache folder for downloaded data (it may not exist yet): GNSSLAB_CACHE, else the system's usual place."""
    if os.environ.get("GNSSLAB_CACHE"):
        return Path(os.environ["GNSSLAB_CACHE"])
    import pooch

    return Path(pooch.os_cache("gnsslab"))
