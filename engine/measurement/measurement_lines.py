"""The lines of text in a measurement file, which may be packed by gzip and in any of the usual encodings."""

import codecs
import gzip
import io
import zlib

MEASUREMENT_SIZE_LIMIT = 16 * 2**20  # bytes, unpacked; some 400,000 samples


def lines_of(content: bytes, largest: int) -> list[str]:
    """Split the bytes of a file into lines.

    Text is UTF-16 if it says so by its first two bytes, else UTF-8, else Latin-1, as older instruments write it.

    Parameters
    ----------
    content : bytes
    largest : int
        Bytes that the file may have, also unpacked.

    Raises
    ------
    ValueError
        If the file is larger, damaged, or no text.
    """
    if content.startswith(b"\x1f\x8b"):
        content = _unpacked(content, largest)
    if len(content) > largest:
        raise ValueError(f"larger than {largest // 2**20} MiB: give fewer periods, or fewer samples of each")
    return _text(content).replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _unpacked(content: bytes, largest: int) -> bytes:
    """What a gzip file holds, of which at most a byte more than allowed is unpacked."""
    try:
        return gzip.GzipFile(fileobj=io.BytesIO(content)).read(largest + 1)
    except (OSError, EOFError, zlib.error) as problem:
        raise ValueError(f"line 1: the gzip file is damaged ({problem}); pack it again, or give it unpacked") from None


def _text(content: bytes) -> str:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace")
    if (zero := content.find(b"\0")) >= 0:
        line = content[:zero].count(b"\n") + 1
        raise ValueError(f"line {line}: a byte 0, so that this is no text; save the file as CSV")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")
