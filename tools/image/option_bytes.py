#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The option bytes that the board's image needs, for tools/image/board.

    option_bytes.py registers IMAGE.bin       prints "OPTR MASK BANKS MASK WHOLE WRP MASK": the protections and the banks in
                                              OPTR under their masks, all of OPTR, WRP1AR under its mask. The read
                                              protection is in no mask.
    option_bytes.py check COPY.bin            refuses a copy of the chip's option bytes (or of OPTR) with other banks
    option_bytes.py patch COPY.bin IMAGE.bin  changes a copy of the chip's option bytes: protected as the image needs it
    option_bytes.py patch COPY.bin            ... or without write protection, for the next flash
    option_bytes.py banks COPY.bin            ... or without write protection and with the banks that the image needs

The bit positions are those of hal/chips/stm32g4/registers/flash.h, which ./tools/test image compares with the crates.
"""

import pathlib
import re
import struct
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
HEADER = ROOT / "hal/chips/stm32g4/registers/flash.h"
PAGE_BYTES = 2048
# A copy holds OPTR, two words of PCROP, WRP1AR and WRP1BR, each followed by its complement.
COPY_BYTES = 40
COPY_OPTR, COPY_WRP1AR, COPY_WRP1BR = 0, 0x18, 0x20


def definitions(header: str) -> dict[str, int]:
    """Fields as masks, and values."""
    fields = {name: ((1 << int(width)) - 1) << int(first)
              for name, first, width in re.findall(r"#define (\w+) FIELD\((\d+), (\d+)\)", header)}
    return fields | {name: int(value, 0) for name, value in re.findall(r"#define (\w+) (0x[0-9A-F]+)u", header)}


FACTS = definitions(HEADER.read_text("utf-8"))
# Parity of the RAM on (active low).
OPTR_MASK, OPTR = FACTS["FLASH_OPTR_SRAM_PE"], 0
# Start from bank 1, two banks with pages of 2 KiB. Changing it needs an erased flash.
BANKS_MASK, BANKS = FACTS["FLASH_OPTR_BFB2"] | FACTS["FLASH_OPTR_DBANK"], FACTS["FLASH_OPTR_DBANK"]
OPTR_WHOLE = FACTS["FLASH_OPTR_RESET"] & ~(OPTR_MASK | BANKS_MASK) | OPTR | BANKS
WRP_MASK = FACTS["FLASH_WRP1AR_WRP1A_STRT"] | FACTS["FLASH_WRP1AR_WRP1A_END"]
WRP_NONE = FACTS["FLASH_WRP1AR_WRP1A_STRT"]  # starts at the last page, ends at page 0


def write_protection(image_bytes: int) -> int:
    """WRP1AR: from page 0 to the last page of the image."""
    end = FACTS["FLASH_WRP1AR_WRP1A_END"]
    last_page = (image_bytes - 1) // PAGE_BYTES
    value = last_page * (end & -end)
    if image_bytes <= 0 or value & ~end:
        raise ValueError(f"an image of {image_bytes} bytes does not fit into bank 1")
    return value


def check_banks(copy: bytes) -> None:
    """Raises ValueError if the image would not find its parameter pages."""
    if len(copy) < 4:
        raise ValueError(f"expected at least 4 option bytes, got {len(copy)}")
    if struct.unpack_from("<I", copy)[0] & BANKS_MASK != BANKS:
        raise ValueError("the flash has one bank, or starts from bank 2")


def patched(copy: bytes, protection: int, banks: bool = False) -> bytes:
    """The chip's option bytes with ours in them, refused if they are not readable, protected against reading, or with
    other banks, which only `banks` changes."""
    if len(copy) != COPY_BYTES:
        raise ValueError(f"expected {COPY_BYTES} option bytes, got {len(copy)}")
    words = list(struct.unpack("<10I", copy))
    if any(word != ~complement & 0xFFFFFFFF for word, complement in zip(words[::2], words[1::2])):
        raise ValueError("an option byte and its complement differ: set the option bytes with openocd")
    if words[0] & FACTS["FLASH_OPTR_RDP"] != FACTS["FLASH_OPTR_RESET"] & FACTS["FLASH_OPTR_RDP"]:
        raise ValueError("the flash is read-protected: remove the read protection first, which erases it")
    if not banks:
        check_banks(copy)
    optr, optr_mask = (OPTR | BANKS, OPTR_MASK | BANKS_MASK) if banks else (OPTR, OPTR_MASK)
    for offset, value, mask in ((COPY_OPTR, optr, optr_mask), (COPY_WRP1AR, protection, WRP_MASK), (COPY_WRP1BR, WRP_NONE, WRP_MASK)):
        word = words[offset // 4] & ~mask | value
        words[offset // 4:offset // 4 + 2] = [word, ~word & 0xFFFFFFFF]
    return struct.pack("<10I", *words)


def main(arguments: list[str]) -> int:
    try:
        match arguments:
            case ["registers", image]:
                wrp = write_protection(pathlib.Path(image).stat().st_size)
                print(*(f"0x{value:08X}" for value in (OPTR, OPTR_MASK, BANKS, BANKS_MASK, OPTR_WHOLE, wrp, WRP_MASK)))
            case ["check", copy]:
                check_banks(pathlib.Path(copy).read_bytes())
            case ["banks", copy]:
                file = pathlib.Path(copy)
                file.write_bytes(patched(file.read_bytes(), WRP_NONE, banks=True))
            case ["patch", copy, *image]:
                file = pathlib.Path(copy)
                protection = write_protection(pathlib.Path(image[0]).stat().st_size) if image else WRP_NONE
                file.write_bytes(patched(file.read_bytes(), protection))
            case _:
                print(__doc__, file=sys.stderr)
                return 2
    except (OSError, ValueError) as error:
        print(f"option_bytes.py: {error}.", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
