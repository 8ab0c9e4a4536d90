"""From the registry to a file on this machine: mirror, cache, what travels with the project, conversion, download; checksum each time."""

import gzip
import shutil

from gnsslab.data.checksums import sha256_of
from gnsslab.data.converting import is_converted, make_converted
from gnsslab.data.locations import cache_folder, mirror_folder, project_folder
from gnsslab.data.registry import find_dataset

TIMEOUT = 20  # [s] without a byte from the server


class DataUnavailable(ValueError):
    """A real data set cannot be had on this machine now; the message says in one line what to do."""


def fetch(name, progress=None):
    """Return the folder that holds every file of a data set under its own name, downloading what is missing.

    The mirror's folder where it has the whole set, else the user's cache. `progress(done, total)` is called with bytes.
    Raises DataUnavailable without network and mirror, ValueError for an unknown name or a wrong checksum.
    """
    dataset = find_dataset(name)
    if _mirror_has(dataset):
        return _mirror_folder_checked(dataset)
    done = 0
    for file in dataset.files:
        path = dataset_path(name, file.name, _shifted(progress, done, file.size, dataset.size))
        _copy_into_cache(path, cache_folder() / name / file.name)
        done += file.size
    return cache_folder() / name


def dataset_path(name, file, progress=None):
    """Return the path of one file of a data set: from the mirror, the cache, the travelling set or the network, in this order.

    A file that the registry says is converted from another is made from that one. `progress(done, total)` is called with
    bytes while a file is being downloaded.
    """
    dataset = find_dataset(name)
    record = dataset.file(file)
    mirrored = _mirrored(dataset, record)
    if mirrored is not None:
        return _checked(mirrored, record)
    cached = cache_folder() / name / file
    if cached.is_file() and _is_sound(cached, dataset, record):
        return cached
    return _unpack(dataset, record, cached) or _convert(dataset, record, cached, progress) or _download(dataset, record, cached, progress)


def verify(name):
    """Return what is the matter with each file of a data set on this machine, a dict by file name: `ok` or words.

    Nothing is downloaded.
    """
    dataset = find_dataset(name)
    return {file.name: _state(dataset, file) for file in dataset.files}


def _mirrored(dataset, record):
    mirror = mirror_folder()
    path = mirror / dataset.name / record.name if mirror else None
    return path if path is not None and path.is_file() else None


def _mirror_has(dataset):
    return all(_mirrored(dataset, record) for record in dataset.files)


def _mirror_folder_checked(dataset):
    for record in dataset.files:
        _checked(_mirrored(dataset, record), record)
    return mirror_folder() / dataset.name


def _checked(path, record):
    if sha256_of(path) != record.sha256:
        raise DataUnavailable(f"{path} is not the registry's file (its sha256 differs): delete it, or correct GNSSLAB_DATA_MIRROR")
    return path


def _is_sound(path, dataset, record):
    """Return whether a file of the cache is the registry's, or was made here from the registry's log."""
    if sha256_of(path) == record.sha256:
        return True
    return bool(record.converted_from) and is_converted(path, dataset.file(record.converted_from).sha256)


def _copy_into_cache(path, cached):
    """Put a file of the mirror into the cache, where the mirror has not the whole set."""
    if path != cached:
        _make_folder(cached.parent)
        shutil.copyfile(path, cached)


def _travelling(dataset, record):
    path = project_folder("datasets") / dataset.name / f"{record.name}.gz"
    return path if path.is_file() else None


def _unpack(dataset, record, target):
    packed = _travelling(dataset, record)
    if packed is None:
        return None
    _make_folder(target.parent)
    target.write_bytes(gzip.decompress(packed.read_bytes()))
    return _checked(target, record)


def _convert(dataset, record, target, progress):
    if not record.converted_from:
        return None
    log = dataset_path(dataset.name, record.converted_from, progress)
    _make_folder(target.parent)
    make_converted(log, target)
    return target


def _download(dataset, record, target, progress):
    import pooch

    if not record.url:
        raise DataUnavailable(
            f"{dataset.name}/{record.name} has no public address (it was {record.made_from}): "
            "put it into a folder and name that folder in GNSSLAB_DATA_MIRROR"
        )
    _make_folder(target.parent)
    pooch.get_logger().setLevel("WARNING")  # its notes belong on no student's screen
    downloader = pooch.HTTPDownloader(progressbar=_PoochProgress(progress) if progress else False, timeout=TIMEOUT)
    try:
        pooch.retrieve(record.url, f"sha256:{record.sha256}", record.name, target.parent, downloader=downloader)
    except OSError as error:  # requests raises its own kinds of OSError
        raise DataUnavailable(_no_network(dataset, error)) from None
    except ValueError:
        raise DataUnavailable(f"{record.url} sent something else than {record.name} (its sha256 differs): try again later") from None
    return target


def _no_network(dataset, error):
    return (
        f"the data set {dataset.name} is not on this machine and cannot be downloaded ({type(error).__name__}): "
        f"connect to the network and type `gnsslab data get {dataset.name}`, or name a folder that has it in GNSSLAB_DATA_MIRROR"
    )


def _make_folder(folder):
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DataUnavailable(f"cannot write to the cache {folder} ({error.strerror}): name another folder in GNSSLAB_CACHE") from None


def _state(dataset, record):
    mirrored, cached = _mirrored(dataset, record), cache_folder() / dataset.name / record.name
    if mirrored is not None:
        return "ok" if sha256_of(mirrored) == record.sha256 else f"wrong checksum: delete {mirrored}"
    if cached.is_file():
        return "ok" if _is_sound(cached, dataset, record) else f"wrong checksum: delete {cached}"
    if _travelling(dataset, record):
        return "ok"
    return "not here yet" if record.url or record.converted_from else "not here, no public address: needs GNSSLAB_DATA_MIRROR"


def _shifted(progress, before, size, total):
    """Return a callback for one file that reports to the callback of the whole set; pooch counts full blocks at the file's end."""
    return (lambda done, _: progress(before + min(done, size), total)) if progress else None


class _PoochProgress:
    """What pooch expects of a progress bar, turned into calls progress(done, total)."""

    def __init__(self, progress):
        self.progress, self.total, self.done = progress, 0, 0

    def update(self, bytes_more):
        self.done += bytes_more
        self.progress(self.done, self.total)

    def reset(self):
        self.done = 0

    def close(self):
        self.progress(self.done, self.total)
