# SPDX-License-Identifier: Apache-2.0
"""Each command in the pages names programs, options, presets, targets and files that exist; each example in another language
can be read. Needs the host build. What is run elsewhere as printed stays there: README.md (tests/readme), the session by
hand in docs/can.md (tests/device/on_socketcan), the first power-up in docs/board.md (tests/target), LIBRARY.md
(tools/servoctl/tests); those blocks are read here, too.
"""

from __future__ import annotations

import functools
import json
import os
import re
import shlex
import subprocess
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from click.testing import CliRunner
from servoctl.cli import servoctl

PROJECT = Path(__file__).resolve().parents[3]
BUILT = PROJECT / "build/host"
PAGES = sorted(
    [*(PROJECT / "docs").rglob("*.md"), *(PROJECT / "tools").glob("*/*.md"), PROJECT / "CONTRIBUTING.md", PROJECT / "README.md"]
)
FOLDERS = ("firmware", "hal", "sim_host", "tests", "tools", "docs", "cmake")
OF_OTHERS = set(
    "apt-get bash cd candump cansend dcfgen do done export grep ip kill mypy pip pipx pre-commit python python3 sha256sum sleep slcand tar until".split()
)
"""Commands of other projects, which the pages use but do not explain."""
OF_THE_PAST = {"sim_host fig9-scan --out DIR": "docs/results/fig9.md names the commit that has it"}
BLOCK = re.compile(r"^(?P<indent> *)```(?P<language>\w*)\n(?P<text>.*?)^(?P=indent)```", re.DOTALL | re.MULTILINE)
INDENTED = re.compile(r"(?<=\n\n)(?:    \S.*\n)+")
INLINE = re.compile(r"`([^`\n]+)`")
OURS = re.compile(r"(?:build/(?:host/)?bin/)?(?:sim_host|servoctl|imager|identify)(?: |$)|tools/\w[\w-]*(?: |$)")


@dataclass(frozen=True)
class Command:
    """One command of a page, as the shell would split it."""

    place: str
    words: tuple[str, ...]

    @property
    def program(self) -> str:
        return self.words[0]

    def options(self) -> list[str]:
        return [word.split("=")[0] for word in self.words[1:] if re.match(r"--?[A-Za-z]", word)]


def blocks(text: str) -> Iterator[tuple[int, str, str]]:
    """Line, language and text of each block; an indented one without a fence is a shell's if it begins with a command of
    ours.
    """
    rest = text
    for found in BLOCK.finditer(text):
        inner = re.sub(f"^{found['indent']}", "", found["text"], flags=re.MULTILINE)
        yield text.count("\n", 0, found.start()) + 2, found["language"], inner
        rest = rest.replace(found[0], "\n" * found[0].count("\n"), 1)
    for found in INDENTED.finditer(rest):
        inner = re.sub("^    ", "", found[0], flags=re.MULTILINE)
        if OURS.match(inner.removeprefix("./")) or inner.startswith(("cmake ", "ctest ", "cd tools", "pip install")):
            yield rest.count("\n", 0, found.start()) + 1, "sh", inner


def shell_lines(language: str, text: str) -> str:
    """What is typed."""
    if language == "console":
        return "\n".join(line[2:] for line in text.splitlines() if line.startswith(("$ ", "# ")))
    return text


def commands_of(text: str, place: str) -> Iterator[Command]:
    """Each simple command, without assignments before it and redirections."""
    for typed in text.replace("\\\n", " ").splitlines():
        line = re.sub(r"\$\([^)]*\)", "1", re.sub(r"(^|\s)#\s.*", "", typed))
        splitter = shlex.shlex(line, posix=True, punctuation_chars=True)
        splitter.whitespace_split = True
        splitter.commenters = ""
        words: list[str] = []
        for word in [*splitter, ";"]:
            if set(word) <= set(";&|()"):
                while words and re.match(r"\w+=", words[0]):
                    words.pop(0)
                if words:
                    yield Command(place, tuple(words))
                words = []
            else:
                words.append(word)


@functools.cache
def presets() -> dict[str, set[str]]:
    content = json.loads((PROJECT / "CMakePresets.json").read_text(encoding="utf-8"))
    kinds = ("configurePresets", "buildPresets", "testPresets", "workflowPresets")
    return {kind.removesuffix("Presets"): {each["name"] for each in content.get(kind, [])} for kind in kinds}


@functools.cache
def targets() -> set[str]:
    """Of the host build, and those that a CMake file of the firmware or a board names."""
    found = set(re.findall(r"^build (\S+?): ", (BUILT / "build.ninja").read_text(encoding="utf-8"), re.MULTILINE))
    for folder in ("firmware", "hal", "cmake", "tests"):
        for file in [*(PROJECT / folder).rglob("CMakeLists.txt"), *(PROJECT / folder).rglob("*.cmake")]:
            text = file.read_text(encoding="utf-8")
            found |= set(re.findall(r"add_(?:custom_target|executable)\(\s*(\w+)", text))
            found |= {name for names in re.findall(r"foreach\(\w+ ([a-z ]+)\)", text) for name in names.split()}
    return found


@functools.cache
def host_tests() -> tuple[set[str], set[str]]:
    """Names and labels."""
    shown = subprocess.run(["ctest", "--show-only=json-v1"], cwd=BUILT, capture_output=True, text=True, check=True).stdout
    names, labels = set(), set()
    for test in json.loads(shown)["tests"]:
        names.add(test["name"])
        labels |= {label for each in test.get("properties", []) if each["name"] == "LABELS" for label in each["value"]}
    return names, labels


@functools.cache
def help_of(*words: str) -> str:
    """What the program says with --help after these words; empty if it does not know them."""
    name, *rest = words
    if name == "servoctl":  # a process for each of its commands would take a minute
        shown = CliRunner().invoke(servoctl, [*rest, "--help"], terminal_width=200)
        return shown.output if shown.exit_code == 0 else ""
    places = {"imager": PROJECT / "build/bin", "sim_host": BUILT / "bin", "identify": BUILT / "bin"}
    done = subprocess.run([places.get(name, PROJECT) / name, *rest, "--help"], capture_output=True, text=True, check=False)
    return done.stdout if done.returncode == 0 else ""


def says(text: str, word: str) -> bool:
    return word == "--help" or re.search(rf"(?<![\w-]){re.escape(word)}(?![\w-])", text) is not None


def fault_of_program(command: Command) -> str:
    """Of sim_host, identify, servoctl and imager: an unknown subcommand or option."""
    name = Path(command.program).name
    path, said = [name], [help_of(name)]
    for word in command.words[1:]:
        if name == "imager" or not re.fullmatch(r"[a-z][a-z0-9-]*", word) or (more := help_of(*path, word)) in ("", said[-1]):
            break  # an option or an argument
        path.append(word)
        said.append(more)
    if len(path) == 1 and len(command.words) > 1 and name != "imager" and not command.words[1].startswith("-"):
        return f"{name} has no command '{command.words[1]}'"
    unknown = [option for option in command.options() if not says(" ".join(said), option)]
    return f"{' '.join(path)} has no option {', '.join(unknown)}" if unknown else ""


def fault_of_script(command: Command) -> str:
    """Of tools/: no such script, or an option, mode or step that its help does not name."""
    name = command.program.removeprefix("./")
    if not os.access(PROJECT / name, os.X_OK):
        return f"there is no script {name}"
    text = help_of(name)
    words = command.options() + ([word for word in command.words[1:] if re.fullmatch(r"[a-z][a-z0-9-]*", word)] if name in ("tools/setup", "tools/test", "tools/update-docs") else [])
    unknown = [word for word in words if not says(text, word)]
    return f"{name} does not know {', '.join(unknown)}" if unknown else ""


def after(words: tuple[str, ...], option: str) -> list[str]:
    """The words that follow an option, up to the next one."""
    if option not in words:
        return []
    rest = words[words.index(option) + 1 :]
    return list(rest[: next((i for i, word in enumerate(rest) if word.startswith("-")), len(rest))])


def fault_of_cmake(command: Command) -> str:
    kind = "build" if "--build" in command.words else "workflow" if "--workflow" in command.words else "configure"
    for name in after(command.words, "--preset"):
        if name not in presets()[kind]:
            return f"there is no {kind} preset {name}"
    for name in after(command.words, "--target"):
        if name not in targets():
            return f"there is no target {name}"
    return ""


def fault_of_ctest(command: Command) -> str:
    names, labels = host_tests()
    for name in after(command.words, "--preset"):
        if name not in presets()["test"]:
            return f"there is no test preset {name}"
    for option, known in (("-R", names), ("-L", labels)):
        for pattern in after(command.words, option):
            if not any(re.search(pattern, each) for each in known):
                return f"no test fits {option} '{pattern}'"
    return ""


def fault_of(command: Command, *folders: Path) -> str:
    """What is wrong with it, or nothing. `folders`: where it may be typed."""
    if " ".join(command.words) in OF_THE_PAST:
        return ""
    name = Path(command.program).name
    checks: dict[str, Callable[[Command], str]] = {"cmake": fault_of_cmake, "ctest": fault_of_ctest}
    for program in ("sim_host", "servoctl", "imager", "identify"):
        checks[program] = fault_of_program
    if command.program.removeprefix("./").startswith("tools/"):
        check = fault_of_script
    elif name in checks:
        check = checks[name]
    elif command.program.startswith("build/host/bin/"):
        check = lambda _: "" if name in targets() or f"bin/{name}" in targets() else f"there is no program {name}"  # noqa: E731
    elif name in OF_OTHERS:
        check = lambda _: ""  # noqa: E731
    else:
        return f"unknown program '{command.program}'"
    if fault := check(command):
        return fault
    for word in command.words[1:]:
        place = word.split("=")[-1].split("::")[0]
        if re.match(rf"(?:{'|'.join(FOLDERS)})/[\w./-]+$", place) and not any((base / place).exists() for base in folders):
            return f"there is no {place}"
    return ""


def commands_in(page: Path) -> Iterator[Command]:
    """Of its blocks, and those of ours in its text."""
    text = page.read_text(encoding="utf-8")
    name = page.relative_to(PROJECT)
    for line, language, block in blocks(text):
        if language in ("sh", "console"):
            yield from commands_of(shell_lines(language, block), f"{name}:{line}")
    prose = BLOCK.sub(lambda found: "\n" * found[0].count("\n"), text)
    for found in INLINE.finditer(prose):
        typed = found[1].removeprefix("./")
        if OURS.match(typed) and not re.search(r"[…<>*]|\.\.\.", typed) and not (PROJECT / typed).is_dir():
            yield from commands_of(typed.replace("\\|", "|"), f"{name}:{prose.count(chr(10), 0, found.start()) + 1}")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(PROJECT)))
def test_every_command_of_a_page_can_be_typed(page: Path) -> None:
    commands = list(commands_in(page))
    folders = [PROJECT, *(PROJECT / each.words[1] for each in commands if each.program == "cd")]
    faults = [(each, fault_of(each, *folders)) for each in commands]
    assert [f"{each.place}: {' '.join(each.words)}: {fault}" for each, fault in faults if fault] == []


def test_every_example_can_be_read() -> None:
    """sh by bash, python by Python, toml by tomllib, json by json."""
    count = 0
    for page in PAGES:
        for line, language, text in blocks(page.read_text(encoding="utf-8")):
            place = f"{page.relative_to(PROJECT)}:{line}"
            count += 1
            if language in ("sh", "console"):
                done = subprocess.run(["bash", "-n"], input=shell_lines(language, text), capture_output=True, text=True, check=False)
                assert done.returncode == 0, f"{place}: {done.stderr}"
            elif language == "python":
                compile(text, place, "exec")
            elif language == "toml":
                tomllib.loads(text)
            elif language == "json":
                json.loads(text)
            else:
                assert language in ("", "text"), f"{place}: '{language}' is no language that is checked"
    print(f"{count} blocks")
    assert count > 100
