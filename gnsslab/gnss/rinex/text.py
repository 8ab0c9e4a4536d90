"""From a file on disk to plain RINEX text: decompression and line ends."""

import io
import warnings
import zlib
from pathlib import Path

from gnsslab.gnss.rinex.errors import RinexError, quoted

_GZIP, _COMPRESS, _BZIP2, _ZIP = b"\x1f\x8b", b"\x1f\x9d", b"BZh", b"PK\x03\x04"
_COMPRESSED_NAMES = (".gz", ".z", ".bz2", ".zip")
_DOS_END = b"\x1a"
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"


def read_bytes(path):
    r"""Return the plain text of a RINEX file as bytes with line ends "\n", whatever it is packed in.

    Plain, gzip, Unix compress (.Z), bzip2, zip and Hatanaka-compressed observations are told apart by their first
    bytes, not by their names. Raises RinexError where the file is missing, a folder, empty or damaged.
    """
    return read_text(path)[0]


def read_text(path):
    """Return what `read_bytes` returns, and a tuple of what decompression complained of, in words."""
    content = _stored_bytes(path)
    content = _unpacked(content, path)
    content, complaints = _without_hatanaka(content, path)
    return _plain_lines(content), complaints


def _stored_bytes(path):
    try:
        content = Path(path).read_bytes()
    except FileNotFoundError:
        raise RinexError(path, "there is no such file; check the name and the folder") from None
    except IsADirectoryError:
        raise RinexError(path, "this is a folder; name a RINEX file in it") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RinexError(path, f"the file cannot be read ({reason})") from None
    if not content:
        raise RinexError(path, "the file is empty; expected a RINEX header")
    return content


def _unpacked(content, path):
    if content.startswith(_GZIP):
        return _not_empty(_gunzipped(content, path), path)
    if content.startswith((_COMPRESS, _BZIP2, _ZIP)):
        return _not_empty(_unpacked_by_hatanaka(content, path), path)
    packed_name = str(path).lower().endswith(_COMPRESSED_NAMES)
    if packed_name and b"RINEX" not in content[:200]:
        found = quoted(content[:12])
        raise RinexError(path, f"expected compressed data as the name says, found {found}; fetch the file again")
    return content


def _gunzipped(content, path):
    plain = io.BytesIO()
    while content.startswith(_GZIP):  # a gzip file may hold several members, one behind the other
        member = zlib.decompressobj(wbits=31)
        try:
            plain.write(member.decompress(content))
        except zlib.error as error:
            raise RinexError(path, f"the gzip data are damaged ({error}); fetch the file again") from None
        if not member.eof:
            raise RinexError(path, "the gzip data end too early; fetch the file again")
        content = member.unused_data
    return plain.getvalue()


def _unpacked_by_hatanaka(content, path):
    import hatanaka

    try:
        return hatanaka.decompress(content)
    except Exception as error:  # whatever the unpackers behind it raise on damaged data
        raise RinexError(path, f"the compressed data are damaged ({_one_line(error)}); fetch the file again") from None


def _without_hatanaka(content, path):
    if b"COMPACT RINEX FORMAT" not in content[:80]:
        return content, ()
    import hatanaka

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            content = hatanaka.crx2rnx(content)
        except Exception as error:  # the package starts a program of its own, which can fail in many ways
            problem = f"the Hatanaka-compressed data are damaged ({_one_line(error)}); fetch the file again"
            raise RinexError(path, problem) from None
    return content, tuple(f"Hatanaka decompression: {_one_line(item.message)}" for item in caught)


def _not_empty(content, path):
    if not content:
        raise RinexError(path, "nothing is in the compressed file; expected a RINEX header")
    return content


def _one_line(error):
    words = " ".join(str(error).split()) or type(error).__name__
    return words if len(words) <= 200 else words[:197] + "..."


def _plain_lines(content):
    content = content.removeprefix(_BYTE_ORDER_MARK).removesuffix(_DOS_END)
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return content
