"""servoctl: tuning of a trackservo over CANopen, the same on the simulator and on the board."""

from pathlib import Path

__version__ = (Path(__file__).parent / "descriptions" / "version.txt").read_text(encoding="ascii").strip()
"""That of the firmware whose build printed the descriptions: project(VERSION) of CMakeLists.txt."""
