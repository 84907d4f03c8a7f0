# SPDX-License-Identifier: Apache-2.0
"""Large texts of the page, compressed: the plotting library and the plots are inflated by the browser when they are looked at."""

from __future__ import annotations

import base64
import zlib


def packed(text: str) -> str:
    """zlib's format in base64, for `DecompressionStream("deflate")`; the same text gives the same bytes."""
    return base64.b64encode(zlib.compress(text.encode("utf-8"), 9)).decode("ascii")


def unpacked(text: str) -> str:
    """What `packed` was given."""
    return zlib.decompress(base64.b64decode(text)).decode("utf-8")
