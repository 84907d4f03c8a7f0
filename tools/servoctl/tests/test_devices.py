"""The same tests run at the simulator and at the image on the emulated board; the exceptions are listed with their
reason."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from .conftest import DEVICE, ROOT, SIMULATOR_ONLY, Bench

TESTS = sorted(Path(__file__).parent.glob("test_*.py"))


def test_only_listed_tests_are_left_out_on_the_image() -> None:
    names = [
        node.name for path in TESTS for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.FunctionDef)
    ]
    for name, reason in SIMULATOR_ONLY.items():
        assert names.count(name) == 1 and len(reason) > 20
    others = [path.name for path in TESTS if re.search(r"pytest\.(mark\.)?(skip|xfail)", path.read_text())]
    assert others == []
    reported = set(re.findall(r"`(test_\w+)`: simulator only", (ROOT / "docs" / "emulator.md").read_text()))
    assert reported == set(SIMULATOR_ONLY)


def test_the_image_is_the_one_that_was_requested(servo: Bench) -> None:
    """1018:4 is the CRC-32 of the chip's unique identifier, which a simulator does not have."""
    assert (servo.json("info")["serial"] > 0xFFFF) == (DEVICE == "image")
