# SPDX-License-Identifier: Apache-2.0
"""The session of docs/can.md with can-utils alone, exactly as on the page. Needs vcan0: see tests/socketcan.

Each `sh` block of the section "By hand" is run; candump must print the lines of the `text` block after it.
"""

import re
import subprocess
import time

import pytest

from device import PROJECT, REAL_TIME

PAGE = PROJECT / "docs/can.md"
ANSWER_TIME_S = 3.0


def session():
    """(commands, lines of candump) in the order of the page."""
    section = PAGE.read_text().split("\n## By hand\n")[1].split("\n## ")[0]
    steps = []
    for language, text in re.findall(r"```(sh|text)\n(.*?)```", section, re.S):
        if language == "sh":
            steps.append((text, []))
        else:
            steps[-1][1].extend(text.splitlines())
    return steps


class Candump:
    def __init__(self, command, path):
        self.path = path
        self.process = subprocess.Popen(command.split(), stdout=path.open("w"))
        self.seen = 0

    def lines(self):
        return [" ".join(line.split()) for line in self.path.read_text().splitlines()]

    def expect(self, patterns):
        """The lines come in this order, with others between them."""
        end = time.monotonic() + ANSWER_TIME_S
        for pattern in patterns:
            pattern = re.compile(" ".join(pattern.split()).replace("[", r"\[").replace("]", r"\]"))
            while True:
                lines = self.lines()
                found = [i for i in range(self.seen, len(lines)) if pattern.fullmatch(lines[i])]
                if found:
                    self.seen = found[0] + 1
                    break
                assert time.monotonic() < end, f"no \"{pattern.pattern}\" in {lines[self.seen:]}"
                time.sleep(0.05)

    def close(self):
        self.process.terminate()
        self.process.wait(timeout=10)


def test_page_has_the_session():
    steps = session()
    assert steps[0][0].startswith("candump vcan0")
    assert sum(text.count("cansend") for text, _ in steps) > 20


@pytest.mark.speed(REAL_TIME)
def test_session_of_the_page_works_line_by_line(vcan0, tmp_path):
    steps = session()
    candump = Candump(steps[0][0], tmp_path / "candump.txt")
    try:
        candump.expect(steps[0][1])
        for commands, answers in steps[1:]:
            # In sequence, as by hand: a command is sent when the previous one has its answer.
            subprocess.run(["bash", "-e", "-c", commands.replace("\ncansend", "\nsleep 0.05\ncansend")], check=True)
            candump.expect(answers)
        answers = [line for line in candump.lines() if line.startswith("vcan0 581")]
        rates = [int.from_bytes(bytes.fromhex(line[-11:]), "little", signed=True)
                 for line in answers if "43 6C 60 00" in line]
        assert rates[:2] == [pytest.approx(17453, rel=0.05)] * 2
        assert abs(rates[2]) < 500
        assert not [line for line in candump.lines() if line.startswith("vcan0 081")]
    finally:
        candump.close()
