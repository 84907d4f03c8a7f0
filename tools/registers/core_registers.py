# SPDX-License-Identifier: Apache-2.0
"""Registers of the Cortex-M4 core as the crate `cortex-m` lays them out: Rust structs without offsets in words."""

import pathlib
import re

_TYPE_BYTES = {"u32": 4, "RW<u32>": 4, "RO<u32>": 4, "WO<u32>": 4, "RW<u8>": 1}
_FIELD = re.compile(r"(?P<attributes>(?:^\s*#\[cfg\([^\n]*\n)*)^\s*(?:pub )?(?P<name>\w+): (?P<type>[^\n]+),$", re.MULTILINE)


def _bytes_of(type_name: str) -> int | None:
    array = re.match(r"\[(.+); (\d+)\]", type_name)
    element = _TYPE_BYTES.get(array[1] if array else type_name)
    return None if element is None else element * (int(array[2]) if array else 1)


def read_offsets(path: pathlib.Path) -> dict[str, int]:
    """Offset of each register of an ARMv7-M core, up to the first that is a struct of its own."""
    body = re.search(r"pub struct RegisterBlock \{(.*?)^\}", path.read_text("utf-8"), re.DOTALL | re.MULTILINE)
    offsets: dict[str, int] = {}
    at = 0
    for field in _FIELD.finditer(body[1]):
        if "#[cfg(armv6m)]" in field["attributes"] or "#[cfg(armv8m)]" in field["attributes"]:
            continue
        size = _bytes_of(field["type"])
        if size is None:
            break
        offsets[field["name"]] = at
        at += size
    return offsets


def read_addresses(folder: pathlib.Path) -> dict[str, int]:
    text = (folder / "mod.rs").read_text("utf-8")
    found = re.findall(r"PTR: \*const (\w+)::RegisterBlock = 0x([0-9A-Fa-f_]+) as", text)
    return {block.upper(): int(address.replace("_", ""), 16) for block, address in found}
