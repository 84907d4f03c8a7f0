# SPDX-License-Identifier: Apache-2.0
"""What MkDocs does for the site beside mkdocs.yml: pages that do not lie in docs/, links to sources, formulas as MathML."""

from __future__ import annotations

import html
import logging
import re
from importlib.util import find_spec
from pathlib import Path
from posixpath import dirname, join, normpath, relpath
from typing import TYPE_CHECKING
from urllib.parse import quote, urlsplit
from xml.etree.ElementTree import Element

import parameter_names
from latex2mathml.converter import convert
from markdown import Extension, Markdown
from markdown.treeprocessors import Treeprocessor
from mkdocs.structure.files import File

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

HERE = Path(__file__).resolve().parent
PROJECT = HERE.parents[1]

log = logging.getLogger("mkdocs.hooks.trackservo")  # a warning of it fails the build

ADDED = {
    "servoctl.md": "tools/servoctl/README.md",
    "servoctl-library.md": "tools/servoctl/LIBRARY.md",
    "report.md": "tools/report/README.md",
    "contributing.md": "CONTRIBUTING.md",
    "changelog.md": "CHANGELOG.md",
}
"""Pages that do not lie in docs/, with their place in the project."""
PAGES = {"README.md": "README.md", **{place: page for page, place in ADDED.items()}}
"""Page by its place in the project, of those that do not lie in docs/. For the project's README it is the start page."""
ON_THE_SITE = (".md", ".svg", ".png")
FORMULA = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)
DRAWING = re.compile(r'<div class="highlight">(<pre>(?:(?!</pre>)[^─│])*[─│])')
"""A code block with lines of signs."""
BAR = '<mo stretchy="false">&#x0007C;</mo>'
"""Of an absolute value: without the space that the sign has between two operands."""
OUTSIDE_ITS_ITEM = re.compile(r"(?<=\n\n) {1,3}\S.*|(?<=\n) {1,3}(?:[-*+]|\d+\.|```|\|) .*")
SEARCH = 'data-md-component="search" role="dialog"'
CODE = re.compile(r"^( *)```.*?^\1```", re.DOTALL | re.MULTILINE)


def place_of(page: str) -> str:
    """Where a page of the site lies in the project."""
    return ADDED.get(page, f"docs/{page}")


def page_of(place: str) -> str | None:
    """The page of the site that a file of the project is; None if it is none."""
    if place.startswith("docs/") and place.endswith(ON_THE_SITE):
        return place.removeprefix("docs/")
    return PAGES.get(place)


class Links(Treeprocessor):
    """Gives a link out of docs/ an address that holds on the site: a page of it, or the file in the repository. Without an
    address of the repository, and for what a build writes, the link becomes text that says where the file lies.
    """

    page = ""
    repository = ""

    def run(self, root: Element) -> None:
        for link in root.iter("a"):
            address = urlsplit(link.get("href", ""))
            if address.path and not address.scheme and not address.netloc:
                self._mend(link, address.path, f"#{address.fragment}" if address.fragment else "")

    def _mend(self, link: Element, path: str, anchor: str) -> None:
        place = normpath(join(dirname(place_of(self.page)), path))
        target = PROJECT / place
        page = page_of(place)
        built = place.startswith("build/")
        if page is not None:
            link.set("href", relpath(page, dirname(self.page) or ".") + anchor)
        elif not built and not target.exists():
            return  # MkDocs says that it leads nowhere
        elif built or not self.repository:
            link.tag = "span"
            del link.attrib["href"]
            link.set("title", place)
        else:
            kind = "tree" if target.is_dir() else "blob"
            link.set("href", f"{self.repository}/{kind}/HEAD/{quote(place)}{anchor}")


class LinksExtension(Extension):
    """Runs just before MkDocs looks at the links, which it does last."""

    def extendMarkdown(self, md: Markdown) -> None:
        md.treeprocessors.register(links, "trackservo_links", 1)


links = Links()


def on_config(config: MkDocsConfig) -> None:
    """Also shows the address of the repository at the foot of each page."""
    links.repository = (config.extra["repository"] or "").rstrip("/")
    config.markdown_extensions.append(LinksExtension())
    if links.repository:
        config.extra["social"] = [{"icon": "material/source-branch", "link": links.repository, "name": "Repository"}]


def on_files(files: Files, config: MkDocsConfig) -> None:
    """Adds the pages, and what they are shown with."""
    for page, place in ADDED.items():
        files.append(File.generated(config, page, abs_src_path=str(PROJECT / place)))
    slug = config.mdx_configs["toc"]["slugify"]
    names = parameter_names.page(lambda heading: slug(heading, "-"))
    files.append(File.generated(config, "parameters.md", content=names))
    for asset in ("site.css", "site.js", "favicon.svg"):
        files.append(File.generated(config, f"assets/{asset}", abs_src_path=str(HERE / asset)))
    font = Path(find_spec("ziamath").origin).parent / "fonts" / "STIXTwoMath-Regular.ttf"
    files.append(File.generated(config, f"assets/{font.name}", abs_src_path=str(font)))


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> None:
    """Refuses what Python-Markdown takes for the end of a list item, and code hosts do not."""
    links.page = page.file.src_uri
    if page.is_homepage:
        page.meta["hide"] = ["navigation", "toc"]
    text = CODE.sub(lambda block: block[0].split("\n")[0] + "\n" * block[0].count("\n"), markdown)
    for found in OUTSIDE_ITS_ITEM.finditer(text):
        line = text.count("\n", 0, found.start()) + 1
        log.warning(
            "%s:%d: '%s' would end the list item that it belongs to: indent it by 4 spaces.",
            place_of(page.file.src_uri), line, found[0].strip()[:40],
        )  # fmt: skip


def on_page_content(content: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Formulas as MathML, which browsers show without a script; drawings with a class of their own."""
    shown = DRAWING.sub(r'<div class="drawing highlight">\1', content)
    return FORMULA.sub(lambda found: formula(found[1], html.unescape(found[2]), place_of(page.file.src_uri)), shown)


def on_post_page(output: str, **_: object) -> str:
    """Names the theme's search for screen readers."""
    return output.replace(SEARCH, f'{SEARCH} aria-label="Search"')


def on_post_template(output_content: str, **_: object) -> str:
    """The page "not found" is a template, not a page."""
    return on_post_page(output_content)


def formula(element: str, tex: str, place: str) -> str:
    """As MathML, in a span, or in a div if it stands alone."""
    try:
        shown = convert(tex, display="block" if element == "div" else "inline")
    except Exception as error:
        log.warning("%s: the formula '%s' cannot be shown: %s", place, tex, error)
        return ""
    shown = shown.replace(BAR, BAR.replace("<mo", '<mo lspace="0" rspace="0"'))
    return f'<{element} class="formula">{shown}</{element}>'
