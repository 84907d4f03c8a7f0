# SPDX-License-Identifier: Apache-2.0
"""The image processor of a trackservo: pictures in, camera frames on CAN out."""

import os

__version__ = "1.0.0"

# Before cv2 is imported anywhere: the imager reports errors itself, in one sentence.
os.environ.setdefault("OPENCV_LOG_LEVEL", "OFF")
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
