# SPDX-License-Identifier: Apache-2.0
"""Present and past errors of a node, with the words for them: objects 1001, 1003 and 603F."""

from __future__ import annotations

from typing import Any

from ..drive.power import state_of
from ..link.device import Device
from .fault_table import SOURCES, FaultTable, Words, origin
from .parameter import AXES, AXIS_SHIFT


def words_data(words: Words) -> dict[str, Any]:
    """For JSON."""
    return dict(vars(words))


def read_faults(device: Device, table: FaultTable) -> dict[str, Any]:
    """Error register, history and the state of each axis, from the device."""
    history = []
    count = device.try_upload(0x1003, 0)
    for sub in range(1, (count[0] if count else 0) + 1):
        value = device.read_int(0x1003, sub)
        code, info = value & 0xFFFF, value >> 16
        history.append(
            {"code": code, "info": info, "meaning": _names(table, code, table.reported(code, info)),
             "origin": origin(code, info)}
        )  # fmt: skip
    axes = []
    for axis, name in enumerate(AXES):
        if device.has_axis(axis):
            data = device.try_upload(0x603F + AXIS_SHIFT * axis)
            code = int.from_bytes(data, "little") if data else 0
            words = _of_axis(table, code, name, history)
            axes.append(
                {"axis": name, "state": state_of(device.axis_int(axis, 0x6041)), "code": code,
                 "meaning": _names(table, code, words), "faults": [words_data(w) for w in words]}
            )  # fmt: skip
    return {"register": device.read_int(0x1001), "axes": axes, "history": history}


def _names(table: FaultTable, code: int, found: list[Words]) -> str:
    return " or ".join(words.name for words in found) or table.meaning(code)


def _of_axis(table: FaultTable, code: int, axis: str, history: list[dict[str, Any]]) -> list[Words]:
    """The fault of an axis: 603F gives a code, which several faults may share; the newest entry of the history gives
    its number."""
    if code == 0:
        return []
    infos = (h["info"] for h in history if h["code"] == code and h["origin"] == axis)
    return table.reported(code, next(infos, SOURCES.index(axis) << 8))
