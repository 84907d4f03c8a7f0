# SPDX-License-Identifier: Apache-2.0
"""Reads and checks a long trajectory as `servoctl follow` does, and prints seconds and memory. A command for people, not for CI:

    cd tools/servoctl && ../../build/venv/bin/python -m tests.time_trajectory --rows 600000

Memory is what the process needs in addition to the imported modules, at its most. Run it on a computer that does nothing else.
"""

from __future__ import annotations

import argparse
import math
import resource
import tempfile
import time
from pathlib import Path

from servoctl.drive.node_limits import Bound, NodeLimits
from servoctl.motion.cable_wrap import longest_within, with_turns
from servoctl.motion.trajectory import AxisLimits, read_trajectory

LIMITS = AxisLimits(NodeLimits(Bound(-3.0, "607D:1"), Bound(3.0, "607D:2"), Bound(1.0, "607F")), 10.0, 10.0)


def write_rows(path: Path, rows: int) -> None:
    """Both axes at 1 kHz, back and forth in 20 s."""
    with path.open("w", encoding="utf-8") as file:
        file.write("time_s,azimuth_deg,pitch_deg\n")
        for row in range(rows):
            angle_deg = 5.0 * math.sin(2.0 * math.pi * 1e-3 * row / 20.0)
            file.write(f"{1e-3 * row:.3f},{angle_deg:.6f},{0.5 * angle_deg:.6f}\n")


def most_bytes() -> int:
    """Of memory that this process has had."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def main() -> None:
    parser = argparse.ArgumentParser(description="Time and memory of reading and checking a trajectory of 1 kHz.")
    parser.add_argument("--rows", type=int, default=600_000, help="number of rows (default: 600000, 10 min)")
    rows: int = parser.parse_args().rows
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "path.csv"
        write_rows(path, rows)
        before_bytes, clock_s, processor_s = most_bytes(), time.monotonic(), time.process_time()
        longest_within(with_turns(read_trajectory(path)), dict.fromkeys(range(2), LIMITS))
        processor_s, clock_s = time.process_time() - processor_s, time.monotonic() - clock_s
    print(f"{rows} rows: {processor_s:.2f} s of processor time, {clock_s:.2f} s, {(most_bytes() - before_bytes) / 1e6:.0f} MB")


if __name__ == "__main__":
    main()
