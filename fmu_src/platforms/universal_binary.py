"""Join Mach-O binaries of several processors into one universal binary, as Apple's lipo does.

Usage: universal_binary.py OUTPUT SLICE...
"""

import struct
import sys
from pathlib import Path

MACH_O_64 = 0xFEEDFACF
UNIVERSAL = 0xCAFEBABE
ALIGNMENT = 14  # 2^14 bytes, a page on Apple's processors


def universal_binary(slices: list[bytes]) -> bytes:
    """Return the universal binary: a big-endian table, then the slices on page boundaries."""
    page = 1 << ALIGNMENT
    table = struct.pack(">II", UNIVERSAL, len(slices))
    body = b""
    for content in slices:
        magic, processor, subtype = struct.unpack_from("<III", content)
        if magic != MACH_O_64:
            raise ValueError("a slice is no 64-bit Mach-O binary")
        offset = page + len(body)
        table += struct.pack(">IIIII", processor, subtype, offset, len(content), ALIGNMENT)
        body += content + bytes(-len(content) % page)
    return table.ljust(page, b"\0") + body


if __name__ == "__main__":
    output, *paths = map(Path, sys.argv[1:])
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_bytes(universal_binary([path.read_bytes() for path in paths]))
    output.chmod(0o755)
