"""Writes a video with the target's box, its error and the quality: the picture that a window would show."""

from __future__ import annotations

from pathlib import Path

import cv2

from .errors import ImagerError
from .follower import Sighting, State
from .picture import Picture

CODECS = {".avi": "MJPG", ".mp4": "mp4v", ".mkv": "MJPG"}
_FOLLOWED, _CORRELATED, _TEXT = (80, 220, 80), (60, 200, 255), (255, 255, 255)


class Recorder:
    """Use: `write` for each picture, then `close`."""

    def __init__(self, file: Path, rate_hz: float) -> None:
        """Raises ImagerError for a kind of file or a folder that cannot be used."""
        if file.suffix.lower() not in CODECS:
            raise ImagerError(f"--record '{file}': expected a file name that ends with {', '.join(CODECS)}.")
        if not file.absolute().parent.is_dir():
            raise ImagerError(f"--record '{file}': the folder does not exist.")
        self._file = file
        self._rate_hz = rate_hz
        self._writer: cv2.VideoWriter | None = None

    def write(self, picture: Picture, sighting: Sighting, error_rad: tuple[float, float]) -> None:
        """The picture with its overlay."""
        height, width = picture.grey.shape
        if self._writer is None:
            code = cv2.VideoWriter.fourcc(*CODECS[self._file.suffix.lower()])
            self._writer = cv2.VideoWriter(str(self._file), code, self._rate_hz, (width, height))
            if not self._writer.isOpened():
                raise ImagerError(f"--record '{self._file}': the file cannot be written.")
        shown = cv2.cvtColor(picture.grey, cv2.COLOR_GRAY2BGR)
        middle = ((width - 1) // 2, (height - 1) // 2)
        cv2.drawMarker(shown, middle, _TEXT, cv2.MARKER_CROSS, 12, 1)
        text = f"{picture.number}  {sighting.state.value}"
        if sighting.quality:
            colour = _CORRELATED if sighting.by_correlation else _FOLLOWED
            half = (0.5 * sighting.width + 4.0, 0.5 * sighting.height + 4.0)
            corner = (round(sighting.column - half[0]), round(sighting.row - half[1]))
            opposite = (round(sighting.column + half[0]), round(sighting.row + half[1]))
            cv2.rectangle(shown, corner, opposite, colour, 1)
            x, y = (1e6 * error for error in error_rad)
            text += f"  x {x:+.1f} y {y:+.1f} urad  quality {sighting.quality}"
        elif sighting.state == State.FOLLOWING:
            text += "  not seen"
        cv2.putText(shown, text, (8, height - 10), cv2.FONT_HERSHEY_SIMPLEX, 0.5, _TEXT, 1, cv2.LINE_AA)
        self._writer.write(shown)

    def close(self) -> None:
        """Completes the file."""
        if self._writer is not None:
            self._writer.release()
