# SPDX-License-Identifier: Apache-2.0
"""The site as a reader gets it: built without a warning, every link within it leads somewhere, nothing comes from another
host, and axe-core finds nothing serious in headless Chromium, in the light and in the dark.
"""

from __future__ import annotations

import functools
import http.server
import os
import re
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urljoin, urlsplit

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, sync_playwright

PROJECT = Path(__file__).resolve().parents[3]
SERVER, NAME = "https://code.example", "owner/trackservo"
REPOSITORY = f"{SERVER}/{NAME}"
CHROMIUM = shutil.which("chromium") or "/usr/bin/chromium"
KINDS = {
    "start": "",
    "formulas and tables": "theory/",
    "objects": "can-objects/",
    "faults": "faults/",
    "parameters": "parameters/",
    "results": "results/",
    "manual": "servoctl/",
    "code blocks": "can/",
    "Python": "servoctl-library/",
    "TOML": "ci/",
    "decision": "decisions/control/",
    "not found": "404.html",
}
WIDE, NARROW = {"width": 1400, "height": 1000}, {"width": 400, "height": 800}
SERIOUS = {"serious", "critical"}
FEWEST_PAGES, FEWEST_LINKS, FEWEST_FORMULAS = 55, 5000, 300


def run_site(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    environment = {name: value for name, value in os.environ.items() if name != "TRACKSERVO_REPOSITORY"}
    return subprocess.run(
        [PROJECT / "tools/site", *arguments], env=environment, capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """As built without an argument."""
    out = tmp_path_factory.mktemp("site") / "out"
    done = run_site("--out", out)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "WARNING" not in done.stdout + done.stderr
    return out


@dataclass
class Document(HTMLParser):
    """What an HTML file links to and loads, and its places."""

    def __post_init__(self) -> None:
        super().__init__()

    links: list[str] = field(default_factory=list)
    loads: list[str] = field(default_factory=list)
    places: set[str] = field(default_factory=set)
    policy: str = ""
    formulas: int = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        of = {name: value or "" for name, value in attrs}
        self.places |= {of[name] for name in ("id", "name") if name in of}
        if tag == "a" and "href" in of:
            self.links.append(of["href"])
        elif tag == "link" and of.get("rel") in ("stylesheet", "icon", "preload", "preconnect", "dns-prefetch"):
            self.loads.append(of["href"])
        elif tag == "meta" and of.get("http-equiv") == "Content-Security-Policy":
            self.policy = of["content"]
        elif tag == "math":
            self.formulas += 1
        if "src" in of:
            self.loads.append(of["src"])


def documents(site: Path) -> dict[Path, Document]:
    found = {}
    for file in sorted(site.rglob("*.html")):
        found[file] = Document()
        found[file].feed(file.read_text(encoding="utf-8"))
    return found


def broken(site: Path, pages: dict[Path, Document]) -> list[str]:
    """Each link and load within the site that leads nowhere."""
    found = []
    for page, document in pages.items():
        here = "/" + page.relative_to(site).as_posix()
        for link in [*document.links, *document.loads]:
            address = urlsplit(urljoin(here, link))
            if address.scheme or address.netloc:
                continue
            target = site / unquote(address.path).lstrip("/")
            target = target / "index.html" if target.is_dir() else target
            place = unquote(address.fragment)
            if not target.is_file() or (place and target in pages and place not in pages[target].places):
                found.append(f"{here}: {link}")
    return found


def test_every_link_within_the_site_leads_somewhere(site: Path) -> None:
    pages = documents(site)
    links = sum(len(each.links) + len(each.loads) for each in pages.values())
    print(f"{len(pages)} pages, {links} links")
    assert len(pages) >= FEWEST_PAGES and links >= FEWEST_LINKS
    assert broken(site, pages) == []


def test_a_broken_link_is_found(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "index.html").write_text('<a href="a/#here">a</a> <a href="a/#gone">b</a> <a href="b/">c</a> <img src="a/d.png">')
    (tmp_path / "a/index.html").write_text('<p id="here"><a href="..">up</a> <a href="https://code.example/x">out</a>')
    assert broken(tmp_path, documents(tmp_path)) == ["/index.html: a/#gone", "/index.html: b/", "/index.html: a/d.png"]


def test_every_page_forbids_requests_to_other_hosts_and_has_none(site: Path) -> None:
    for page, document in documents(site).items():
        assert document.policy.startswith("default-src 'self';") and "http" not in document.policy, page
        assert [load for load in document.loads if urlsplit(load).netloc] == [], page
    for sheet in site.rglob("*.css"):
        assert not re.search(r"url\(\s*['\"]?(https?:)?//", sheet.read_text(encoding="utf-8")), sheet


def test_every_formula_is_shown(site: Path) -> None:
    """None is left as TeX, which needs a script."""
    pages = documents(site)
    assert sum(each.formulas for each in pages.values()) >= FEWEST_FORMULAS
    for page in pages:
        text = re.sub(r"<(pre|code|script)\b.*?</\1>", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
        assert not re.search(r"\$[^$\n]+\$|\\[(\[]|arithmatex", text), page


def test_links_to_sources_lead_to_the_repository_or_say_the_path(site: Path, tmp_path: Path) -> None:
    """Built as the workflow of a release does, but in a folder of its own."""
    out = tmp_path / "out"
    made = re.search(r"- name: Make the site\n +run: (.*)$", (PROJECT / ".github/workflows/release.yml").read_text("utf-8"), re.MULTILINE)
    assert made
    named = os.environ | {"GITHUB_SERVER_URL": SERVER, "GITHUB_REPOSITORY": NAME}
    subprocess.run(["bash", "-c", f'{made[1]} --out "{out}"'], cwd=PROJECT, env=named, check=True, capture_output=True)
    pages = documents(out)
    sources = {link.removeprefix(f"{REPOSITORY}/") for each in pages.values() for link in each.links if link.startswith(REPOSITORY + "/")}
    kinds = {True: "tree", False: "blob"}
    wrong = [link for link in sources if (kind := link.split("/")[0]) != kinds.get((PROJECT / link.removeprefix(f"{kind}/HEAD/")).is_dir())
             or not (PROJECT / unquote(urlsplit(link).path).removeprefix(f"{kind}/HEAD/")).exists()]  # fmt: skip
    assert len(sources) > 150 and wrong == []
    assert broken(out, pages) == []
    assert "blob/HEAD/firmware/control/lugre.h" in sources
    assert '<span title="firmware/control/lugre.h">' in (site / "theory/index.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--sevre"], "unknown option '--sevre' (see --help)."),
        (["--serve", "many"], "invalid port 'many': expected a number from 1 to 65535."),
        (["--serve", "65536"], "invalid port '65536': expected a number from 1 to 65535."),
        (["--repository", "here"], "invalid repository 'here': expected an address such as https://HOST/OWNER/trackservo."),
        (["--repository"], "--repository needs an address (see --help)."),
        (["--out", PROJECT / "docs"], f"'{PROJECT}/docs' has other files, which would be deleted: name an empty folder."),
    ],
)
def test_a_wrong_argument_gives_one_sentence(arguments: list[str | Path], said: str) -> None:
    done = run_site(*arguments)
    assert (done.returncode, done.stdout, done.stderr) == (1, "", f"site: {said}\n")


def test_a_port_in_use_gives_one_sentence() -> None:
    with http.server.HTTPServer(("127.0.0.1", 0), http.server.BaseHTTPRequestHandler) as server:
        done = run_site("--serve", str(server.server_port))
        assert (done.returncode, done.stderr) == (1, f"site: port {server.server_port} is in use: name another one.\n")


def copy_of_the_project(folder: Path) -> Path:
    """What the site is made from is copied; the rest, to which pages link, is that of the project."""
    for place in PROJECT.iterdir():
        if place.name not in (".git", "build", "docs", "tools"):
            (folder / place.name).symlink_to(place)
    (folder / "tools").mkdir()
    for place in (PROJECT / "tools").iterdir():
        if place.name != "website":
            (folder / "tools" / place.name).symlink_to(place)
    shutil.copytree(PROJECT / "tools/website", folder / "tools/website")
    shutil.copytree(PROJECT / "docs", folder / "docs")
    return folder


def test_mistakes_in_pages_are_warnings_with_their_place(tmp_path: Path) -> None:
    copy = copy_of_the_project(tmp_path)
    text = "# New\n\n[a](gone.md) [b](can.md#gone) [c](../firmware/gone.c)\n\n1. Item\n\n   ```sh\n   ls\n   ```\n"
    (copy / "docs/new.md").write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--config-file", "tools/website/mkdocs.yml"]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True, check=False)
    said = [line for line in done.stderr.splitlines() if line.startswith("WARNING")]
    assert done.returncode == 1
    for part in ("'gone.md'", "'can.md#gone'", "'../firmware/gone.c'", "not included in the \"nav\""):
        assert any("new.md" in line and part in line for line in [*said, done.stderr.replace("\n", " ")]), done.stderr
    assert any("docs/new.md:7: '```sh' would end the list item" in line for line in said), done.stderr


@pytest.fixture(scope="module")
def address(site: Path) -> Iterator[str]:
    """Of a server of the site."""

    class Handler(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_: Any) -> None:
            """Says nothing."""

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=str(site))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as play:
        opened = play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield opened
        opened.close()


@contextmanager
def opened(browser: Browser, address: str, **options: Any) -> Iterator[Page]:
    """A page that asked its own host alone, and complained of nothing."""
    context = browser.new_context(**options)
    page = context.new_page()
    asked: list[str] = []
    complaints: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda message: complaints.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(address)
    page.wait_for_load_state("networkidle")
    yield page
    page.close()
    context.close()
    host = urlsplit(address).netloc
    assert [url for url in asked if urlsplit(url).netloc != host and not url.startswith(("data:", "blob:"))] == []
    assert complaints == []


def serious(page: Page) -> list[tuple[str, list[str]]]:
    """What axe-core finds serious or critical, with some of the elements. All of it is printed."""
    found = Axe().run(page, options={"resultTypes": ["violations"]}).response["violations"]
    print(page.url, [(each["id"], each["impact"], len(each["nodes"])) for each in found])
    return [(each["id"], [node["html"][:160] for node in each["nodes"][:3]]) for each in found if each["impact"] in SERIOUS]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("kind", KINDS)
def test_axe_finds_nothing_serious(browser: Browser, address: str, kind: str, scheme: str) -> None:
    with opened(browser, address + KINDS[kind], viewport=WIDE, color_scheme=scheme) as page:
        dark = page.evaluate("document.body.getAttribute('data-md-color-scheme')") == "slate"
        assert dark == (scheme == "dark")
        assert serious(page) == []


@pytest.mark.parametrize("kind", KINDS)
def test_a_narrow_page_does_not_scroll_to_the_side_and_its_pictures_fit(browser: Browser, address: str, kind: str) -> None:
    """What scrolls by itself there can be reached by the keyboard."""
    with opened(browser, address + KINDS[kind], viewport=NARROW) as page:
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        pictures = page.evaluate("[...document.images].map(i => [i.alt, i.naturalWidth, i.getBoundingClientRect().right])")
        assert all(text and width and right <= NARROW["width"] for text, width, right in pictures)
        assert len(pictures) >= (2 if kind == "start" else 0)
        assert serious(page) == []


def test_the_search_finds_a_word(browser: Browser, address: str) -> None:
    with opened(browser, address, viewport=WIDE) as page:
        page.locator("input.md-search__input").click()
        page.keyboard.type("bristle stiffness")
        # The list follows each letter: the first results are those of fewer letters.
        page.locator(".md-search-result__link:is([href*='parameters'], [href*='can-objects'], [href*='theory'])").first.wait_for()


def test_the_button_switches_to_the_dark_and_back(browser: Browser, address: str) -> None:
    with opened(browser, address, viewport=WIDE, color_scheme="light") as page:
        for label, scheme in (("Switch to dark", "slate"), ("Switch to light", "default")):
            page.locator(f"label[title='{label}']").click()
            assert page.evaluate("document.body.getAttribute('data-md-color-scheme')") == scheme
