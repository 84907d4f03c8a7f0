# SPDX-License-Identifier: Apache-2.0
"""A page that opens offline: one HTML file with tables, and with pictures inside."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import jinja2

from ..errors import InputError


@dataclass(frozen=True)
class PageTable:
    """Cells as shown; `bad` numbers the rows, from 0, that have an error."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    bad: Sequence[int] = ()


@dataclass(frozen=True)
class Section:
    """A heading, a paragraph, a table and a picture (PNG); all but the heading may be missing."""

    title: str
    text: str = ""
    table: PageTable | None = None
    picture: bytes | None = None


def write_page(path: Path, title: str, lead: str, sections: Sequence[Section], notes: Sequence[str] = ()) -> None:
    """`notes` are highlighted, above all sections. Raises InputError when the file cannot be written."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("servoctl"), autoescape=True, trim_blocks=True, lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )  # fmt: skip
    environment.filters["b64"] = lambda data: base64.b64encode(data).decode("ascii")
    template = environment.get_template("page.html.j2")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(template.render(title=title, lead=lead, sections=sections, notes=notes), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}.") from error
