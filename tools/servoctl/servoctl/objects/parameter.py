# SPDX-License-Identifier: Apache-2.0
"""One object of the device: its name, its allowed values, and its form on the bus."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..units import number, parse_quantity, whole_number

Value = bool | int | float | str | bytes

_FORMATS = {
    "BOOLEAN": "<?",
    "INTEGER8": "<b",
    "INTEGER16": "<h",
    "INTEGER32": "<i",
    "UNSIGNED8": "<B",
    "UNSIGNED16": "<H",
    "UNSIGNED32": "<I",
    "UNSIGNED64": "<Q",
    "REAL32": "<f",
}
TYPES = (*_FORMATS, "VISIBLE_STRING", "DOMAIN")

AXES = ("azimuth", "pitch")
AXIS_SHIFT = 0x800
PLANT_OBJECT = 0x2056
"""Added to the indices of the first axis to reach those of the second."""


@dataclass(frozen=True)
class Parameter:
    """A row of parameters.json; `low`, `high` and `default` are in `unit`.

    `guarded`: it can cause damage, so the device accepts it only while its access lock is open.
    """

    name: str
    title: str
    index: int
    sub: int
    type: str
    access: str
    unit: str = ""
    low: float | int | None = None
    high: float | int | None = None
    default: Value | None = None
    stored: bool = False
    rpdo: bool = False
    tpdo: bool = False
    guarded: bool = False
    help: str = ""

    @property
    def where(self) -> str:
        """Index and sub-index, as in 0x2000:01."""
        return f"0x{self.index:04X}:{self.sub:02X}"

    @property
    def axis(self) -> int | None:
        """0 azimuth, 1 pitch, None for objects of the node."""
        head = self.name.split(".", 1)[0]
        return AXES.index(head) if head in AXES else None

    @property
    def staged(self) -> bool:
        """A write waits for "apply": the gains 0x2000 to 0x205F of an axis."""
        return self.axis is not None and 0x2000 <= self.index - AXIS_SHIFT * self.axis < 0x2060

    @property
    def tunable(self) -> bool:
        """Belongs into a gains file: stored, writable, and of an axis."""
        return self.stored and self.access == "rw" and self.axis is not None

    @property
    def writable(self) -> bool:
        """May be written."""
        return self.access in ("rw", "wo")

    @property
    def readable(self) -> bool:
        """May be read."""
        return self.access != "wo"

    @property
    def bits(self) -> int:
        """Length in a PDO, bit; 0 for texts and DOMAIN."""
        return 8 * struct.calcsize(_FORMATS[self.type]) if self.type in _FORMATS else 0

    def decode(self, data: bytes) -> Value:
        """The value of bytes from the bus; a REAL32 comes as the shortest decimal that is this float32."""
        if self.type == "VISIBLE_STRING":
            return data.rstrip(b"\0").decode("ascii", errors="replace")
        if self.type == "DOMAIN":
            return bytes(data)
        layout = struct.Struct(_FORMATS[self.type])
        if len(data) < layout.size:
            raise InputError(
                f"{self.name} ({self.where}): received {len(data)} bytes, but {self.type} has {layout.size}."
            )
        value: Value = layout.unpack_from(data)[0]
        return shortest(value) if isinstance(value, float) else value

    def encode(self, value: Value) -> bytes:
        """The bytes for the bus."""
        if isinstance(value, bytes):
            return value
        if self.type == "VISIBLE_STRING":
            return str(value).encode("ascii")
        if self.type == "DOMAIN":
            raise InputError(f"{self.name} ({self.where}) needs bytes from a file, not '{value}'.")
        try:
            return struct.pack(_FORMATS[self.type], value)
        except (struct.error, OverflowError) as error:
            raise InputError(f"{self.name} ({self.where}): {value} does not fit into {self.type}.") from error

    def parse(self, text: str) -> Value:
        """The value typed by a user, a unit allowed; raises InputError when it is no such value."""
        if self.type in ("VISIBLE_STRING", "DOMAIN"):
            return text
        if self.type == "BOOLEAN":
            known = {
                "1": True,
                "true": True,
                "on": True,
                "yes": True,
                "0": False,
                "false": False,
                "off": False,
                "no": False,
            }
            if text.strip().lower() not in known:
                raise InputError(f"{self.name}: invalid value '{text}': expected on or off.")
            return known[text.strip().lower()]
        if self.type != "REAL32":
            stripped = text.strip()
            if self.unit and stripped.endswith(self.unit):
                stripped = stripped.removesuffix(self.unit).strip()
            try:
                return whole_number(stripped)
            except InputError:
                raise InputError(f"{self.name}: '{text}' is not a whole number{self._range()}.") from None
        try:
            return parse_quantity(text, self.unit)
        except InputError as error:
            raise InputError(f"{self.name}: {error}") from None

    def check(self, value: Value) -> Value:
        """The value in the device's precision; raises InputError when it is not of the type or out of the limits."""
        if self.type in ("VISIBLE_STRING", "DOMAIN"):
            return value
        if isinstance(value, str | bytes):
            raise InputError(f"{self.name}: {value!r} is not a number{self._range()}.")
        if isinstance(value, int) and abs(value) > _LARGEST_WHOLE:
            raise InputError(f"{self.name}: {str(value)[:_SHOWN]}... is beyond every limit{self._range()}.")
        if not math.isfinite(value):
            raise InputError(f"{self.name}: {value} is not finite{self._range()}.")
        if self.type == "REAL32":
            value = shortest(np.float32(value)) if abs(value) < 3.4e38 else float(value)
        elif isinstance(value, float):
            if value != int(value):
                raise InputError(f"{self.name}: {number(value)} is not a whole number{self._range()}.")
            value = int(value)
        if self.low is not None and self.high is not None and self.low <= self.high:
            if value < self.low or value > self.high:
                side = (
                    f"below the lower limit {number(self.low)}"
                    if value < self.low
                    else f"above the upper limit {number(self.high)}"
                )
                raise InputError(
                    f"{self.name}: {number(value)} {self.unit} is {side}{self._range()}.".replace("  ", " ")
                )
        return value

    def wanted(self, value: Value) -> Value:
        """What a user wants to write, a number or a text that may have a unit, checked; raises InputError."""
        if not self.writable:
            raise InputError(f"{self.name} ({self.where}) is read-only.")
        return self.check(self.parse(value) if isinstance(value, str) else value)

    def _range(self) -> str:
        if self.low is None or self.high is None or self.low > self.high:
            return ""
        unit = f" {self.unit}" if self.unit else ""
        return f"; expected {number(self.low)} to {number(self.high)}{unit}"

    def limits(self) -> str:
        """The range as text, in the unit."""
        if self.low is None or self.high is None:
            return ""
        return f"{number(self.low)} … {number(self.high)}"


_LARGEST_WHOLE = 1 << 64
"""What is larger is beyond every type, and may be beyond every float."""
_SHOWN = 12
"""Digits of such a number."""


def shortest(value: float | np.float32) -> float:
    """The shortest decimal that is the same float32."""
    return float(str(np.float32(value)))
