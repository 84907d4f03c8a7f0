#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes length and CRC of an image into its version block.

    stamp_image.py IMAGE.bin BLOCK      changes IMAGE.bin, and writes the finished block to BLOCK

The block is described in hal/version_block.h. Only the standard library is used: the build runs this.
"""

import pathlib
import struct
import sys
import zlib

OFFSET = 0x200
BYTES = 96
MAGIC = 0x56535354
FORMAT = 1
LENGTH_AT = 8
CRC_AT = 12


def stamped(image: bytes) -> bytes:
    """The image with its length and CRC in place. Raises ValueError when it has no version block."""
    if len(image) < OFFSET + BYTES or struct.unpack_from("<II", image, OFFSET) != (MAGIC, FORMAT):
        raise ValueError(f"no version block of format {FORMAT} at offset {OFFSET:#x}")
    result = bytearray(image)
    struct.pack_into("<I", result, OFFSET + LENGTH_AT, len(image))
    crc_at = OFFSET + CRC_AT
    crc = zlib.crc32(bytes(result[:crc_at]) + bytes(result[crc_at + 4:]))
    struct.pack_into("<I", result, crc_at, crc)
    return bytes(result)


def main() -> int:
    if len(sys.argv) != 3:
        print("Usage: stamp_image.py IMAGE.bin BLOCK", file=sys.stderr)
        return 2
    image_file, block_file = (pathlib.Path(argument) for argument in sys.argv[1:])
    try:
        image = stamped(image_file.read_bytes())
    except (OSError, ValueError) as error:
        print(f"stamp_image.py: {image_file}: {error}", file=sys.stderr)
        return 1
    image_file.write_bytes(image)
    block_file.write_bytes(image[OFFSET:OFFSET + BYTES])
    return 0


if __name__ == "__main__":
    sys.exit(main())
