# SPDX-License-Identifier: Apache-2.0
"""Programs of the gate: SIM_HOST and NODE_DESCRIPTIONS in the environment, otherwise the build of the preset host."""

from __future__ import annotations

import json
import os
import subprocess
import xml.etree.ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

PROJECT = Path(__file__).resolve().parents[2]
BIN = PROJECT / "build/host/bin"


@dataclass
class Verdict:
    """One run of the gate."""

    code: int
    out: str
    err: str
    folder: Path

    @property
    def results(self) -> dict[str, Any]:
        """results.json"""
        content: dict[str, Any] = json.loads((self.folder / "results.json").read_text())
        return content

    @property
    def junit(self) -> xml.etree.ElementTree.Element:
        """junit.xml"""
        return xml.etree.ElementTree.parse(self.folder / "junit.xml").getroot()

    @property
    def failures(self) -> list[str]:
        """Messages of the failed test cases."""
        return [failure.attrib["message"] for failure in self.junit.iter("failure")]


class Gate:
    """Runs `sim_host check` with a folder for its files."""

    def __init__(self, program: Path, folder: Path) -> None:
        self.program = program
        self.folder = folder
        self.runs = 0

    def check(self, *arguments: str | Path, program: Path | None = None, threads: int = 1) -> Verdict:
        """Keeps results, page and JUnit of this run apart from those of the others."""
        self.runs += 1
        folder = self.folder / f"run-{self.runs}"
        command = [program or self.program, "check", "--threads", str(threads), "--out", folder]
        command += ["--junit", folder / "junit.xml", *arguments]
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True, cwd=PROJECT, timeout=900)
        return Verdict(done.returncode, done.stdout, done.stderr, folder)


@pytest.fixture(scope="session")
def sim_host() -> Path:
    """The simulator with this tree's firmware."""
    return Path(os.environ.get("SIM_HOST", BIN / "sim_host"))


@pytest.fixture
def gate(sim_host: Path, tmp_path: Path) -> Gate:
    """The gate, with its own folder for the test."""
    return Gate(sim_host, tmp_path)
