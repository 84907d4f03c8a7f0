# SPDX-License-Identifier: Apache-2.0
"""The image processor of a trackservo: pictures in, camera frames on CAN out."""

import os
from pathlib import Path

__version__ = (Path(__file__).parent / "version.txt").read_text(encoding="ascii").strip()
"""That of servoctl, too: project(VERSION) of CMakeLists.txt."""

# Before cv2 is imported anywhere: the imager reports errors itself, in one sentence.
os.environ.setdefault("OPENCV_LOG_LEVEL", "OFF")
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
