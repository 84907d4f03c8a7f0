# SPDX-License-Identifier: Apache-2.0
"""Without a camera, a video, pictures or a bus: one sentence and exit code 2. And what a video becomes."""

from __future__ import annotations

import contextlib
import http.server
import re
import socket
import threading
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from imager.sources import read_pgm

from .conftest import run_imager
from .pictures import HEIGHT, WIDTH, Scene
from .test_kinds_of_pictures import video_at


@pytest.fixture
def video(tmp_path: Path) -> Path:
    """Half a second of a target in front of sky."""
    file = tmp_path / "target.avi"
    writer = cv2.VideoWriter(str(file), cv2.VideoWriter.fourcc(*"MJPG"), 50.0, (WIDTH, HEIGHT))
    scene = Scene()
    for i in range(25):
        writer.write(cv2.cvtColor(scene.picture(300.0 + i, 200.0), cv2.COLOR_GRAY2BGR))
    writer.release()
    return file


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def refused(folder: Path, *arguments: str) -> str:
    """The one sentence."""
    result = run_imager(folder, *arguments)
    assert result.code == 2, result
    assert result.out == ""
    assert result.err.count("\n") == 1 and result.err.startswith("imager: "), result.err
    return result.err


@pytest.mark.parametrize("camera", ["63", "/dev/video63"])
def test_without_a_camera(tmp_path: Path, camera: str) -> None:
    assert f"the camera '{camera}' cannot be opened" in refused(tmp_path, camera, "--no-bus")


def test_without_a_video(tmp_path: Path) -> None:
    assert "the video 'missing.mp4' does not exist" in refused(tmp_path, "missing.mp4", "--no-bus")


def test_with_a_file_that_is_no_video(tmp_path: Path) -> None:
    (tmp_path / "text.mp4").write_text("no video\n" * 1000)
    assert "'text.mp4' is not a video that FFmpeg can read" in refused(tmp_path, "text.mp4", "--no-bus")


def test_with_a_broken_video(tmp_path: Path, video: Path) -> None:
    broken = tmp_path / "broken.avi"
    broken.write_bytes(video.read_bytes()[:6000])  # the head, and a part of the first picture
    text = refused(tmp_path, "broken.avi", "--no-bus")
    assert "'broken.avi'" in text and ("is not a video" in text or "no picture that can be decoded" in text)


def test_a_video_that_breaks_off_or_is_damaged_is_said_after_the_summary(tmp_path: Path, video: Path) -> None:
    """Its first pictures are good: they become frames, and the exit code tells that the file has more."""
    content = video.read_bytes()
    middle = len(content) // 2
    (tmp_path / "cut.avi").write_bytes(content[:middle])
    (tmp_path / "hole.avi").write_bytes(content[:middle] + bytes(5000) + content[middle + 5000 :])
    for name in ("cut.avi", "hole.avi"):
        result = run_imager(tmp_path, name, "--no-bus")
        assert result.code == 2 and "pictures: " in result.out, result
        assert re.fullmatch(rf"imager: the video '{name}' is damaged: \d+ of its 25 pictures cannot be decoded\.\n", result.err), result.err
    assert run_imager(tmp_path, str(video), "--no-bus").code == 0


def test_with_a_folder_without_pictures(tmp_path: Path) -> None:
    (tmp_path / "clips").mkdir()
    assert "the folder 'clips' has no pictures; expected files that end with .png" in refused(tmp_path, "clips", "--no-bus")
    assert "the source is empty" in refused(tmp_path, "", "--no-bus")


@pytest.mark.parametrize("option", ["--pixel-urad", "--camera-delay", "--seconds", "--rate"])
def test_with_a_number_that_is_none(tmp_path: Path, video: Path, option: str) -> None:
    assert f"'{option}': nan is not a finite number" in refused(tmp_path, str(video), "--no-bus", option, "nan")
    for number in ("1_0", "\u0663"):
        assert f"'{option}': '{number}' is not a number" in refused(tmp_path, str(video), "--no-bus", option, number)


def test_with_pictures_that_are_too_small(tmp_path: Path) -> None:
    writer = cv2.VideoWriter(str(tmp_path / "tiny.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 50.0, (64, 16))
    writer.write(np.zeros((16, 64, 3), dtype=np.uint8))
    writer.release()
    assert "have 64 x 16 pixels; a target can be found in 28 x 28 or more" in refused(tmp_path, "tiny.avi", "--no-bus")


def test_without_a_target_it_says_what_the_picture_shows(tmp_path: Path) -> None:
    writer = cv2.VideoWriter(str(tmp_path / "sky.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 50.0, (WIDTH, HEIGHT))
    for _ in range(5):
        writer.write(np.full((HEIGHT, WIDTH, 3), 180, dtype=np.uint8))
    writer.release()
    result = run_imager(tmp_path, "sky.avi", "--no-bus")
    assert result.code == 0
    assert "the target was never found" in result.out and "±3.7 by ±2.8 mrad around the line of sight" in result.out


def test_with_a_stream_that_nobody_serves(tmp_path: Path) -> None:
    address = f"rtsp://127.0.0.1:{free_port()}/uav"
    assert f"the stream '{address}' cannot be opened" in refused(tmp_path, address, "--no-bus")


def test_without_a_simulator(tmp_path: Path) -> None:
    text = refused(tmp_path, f"pgm-tcp:127.0.0.1:{free_port()}", "--no-bus")
    assert "is 'sim_host serve --video' running?" in text


@pytest.mark.parametrize("source", ["pgm-tcp:host", "pgm-tcp:host:0", "pgm-tcp:host:70000"])
def test_with_a_wrong_port(tmp_path: Path, source: str) -> None:
    assert "has no valid port: expected pgm-tcp:HOST:PORT" in refused(tmp_path, source, "--no-bus")


@pytest.mark.parametrize(
    ("sent", "reason"),
    [
        (b"GIF89a\n", "is not a sequence of PGM pictures"),
        (b"P5\n# exposure_us 1\n2 2\n65535\n", "expected grey levels of 8 bits"),
        (b"P5\n2 2\n255\n1234", "has no comment line '# exposure_us"),
        (b"P5\n# exposure_us 1\n", "the stream ends within a picture"),
        (b"P5\n# exposure_us 1\ntwo 2\n255\n", "a picture's size is not a number"),
    ],
)
def test_with_a_stream_of_something_else(tmp_path: Path, sent: bytes, reason: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def serve() -> None:
            client, _ = listener.accept()
            with client:
                client.sendall(sent)

        thread = threading.Thread(target=serve)
        thread.start()
        assert reason in refused(tmp_path, f"pgm-tcp:127.0.0.1:{listener.getsockname()[1]}", "--no-bus")
        thread.join()


def test_without_a_bus(tmp_path: Path, video: Path) -> None:
    assert "no bus given: add --bus or set SERVOCTL_BUS" in refused(tmp_path, video.name)
    assert "invalid bus 'can0'" in refused(tmp_path, video.name, "--bus", "can0")
    text = refused(tmp_path, video.name, "--bus", f"slcan-tcp:127.0.0.1:{free_port()}")
    assert "connection refused" in text


def test_with_a_recording_that_cannot_be_written(tmp_path: Path, video: Path) -> None:
    assert "expected a file name that ends with" in refused(tmp_path, video.name, "--no-bus", "--record", "out.xyz")
    assert "the folder does not exist" in refused(tmp_path, video.name, "--no-bus", "--record", "none/out.avi")


def test_a_recording_replaces_no_file_unless_asked_and_never_the_video(tmp_path: Path, video: Path) -> None:
    kept = tmp_path / "out.avi"
    kept.write_bytes(b"mine")
    (tmp_path / "same.avi").symlink_to(video)
    before = video.read_bytes()
    assert "'out.avi' exists already" in refused(tmp_path, video.name, "--no-bus", "--record", "out.avi")
    for same in (video.name, f"./{video.name}", "same.avi"):
        for source in (video.name, f"file://{video.absolute()}", f"concat:{video.name}", f"async:file:{video.name}"):
            assert "this command reads it" in refused(tmp_path, source, "--no-bus", "--record", same, "--overwrite"), source
    assert kept.read_bytes() == b"mine" and video.read_bytes() == before
    assert run_imager(tmp_path, video.name, "--no-bus", "--record", "out.avi", "--overwrite").code == 0
    assert kept.stat().st_size > 1000


def test_a_recording_does_not_replace_what_a_playlist_may_play(tmp_path: Path, video: Path) -> None:
    before = video.read_bytes()
    (tmp_path / "list.ffconcat").write_text(f"ffconcat version 1.0\nfile {video.name}\n")
    video_at(tmp_path / "part.ts", [0.04 * i for i in range(25)], codec="mpeg4")
    (tmp_path / "list.m3u8").write_text("#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\npart.ts\n#EXT-X-ENDLIST\n")
    for source in ("list.ffconcat", "list.m3u8"):
        text = refused(tmp_path, source, "--no-bus", "--record", video.name, "--overwrite")
        assert f"'{video.name}' exists already" in text and f"'{source}' may play it: give a new name" in text
    assert video.read_bytes() == before
    assert run_imager(tmp_path, "list.ffconcat", "--no-bus", "--record", "new.avi").code == 0


def test_a_video_is_followed_and_recorded(tmp_path: Path, video: Path) -> None:
    result = run_imager(tmp_path, video.name, "--no-bus", "--record", "out.avi")
    assert result.code == 0, result.err
    assert "pictures: 25" in result.out
    assert "target found in 23 of 25 pictures, lost 0 times" in result.out
    assert "delay, exposure to frame sent: median" in result.out
    recorded = cv2.VideoCapture(str(tmp_path / "out.avi"))
    assert int(recorded.get(cv2.CAP_PROP_FRAME_COUNT)) == 25
    recorded.set(cv2.CAP_PROP_POS_FRAMES, 20)
    good, picture = recorded.read()
    assert good
    green = (picture[..., 1].astype(int) - picture[..., 2] > 60) & (picture[..., 1].astype(int) - picture[..., 0] > 60)
    rows, columns = np.nonzero(green)  # the box around the target
    assert abs(columns.mean() - 320.0) < 3.0 and abs(rows.mean() - 200.0) < 3.0


class _Camera(http.server.BaseHTTPRequestHandler):
    """A network camera: two seconds of JPEG pictures, then it breaks off."""

    def do_GET(self) -> None:  # noqa: N802
        scene = Scene()
        self.send_response(200)
        self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=picture")
        self.end_headers()
        with contextlib.suppress(OSError):
            for i in range(60):
                data = cv2.imencode(".jpg", scene.picture(300.0 + 0.5 * i, 200.0))[1].tobytes()
                self.wfile.write(b"--picture\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(data))
                self.wfile.write(data + b"\r\n")
                time.sleep(0.033)

    def log_message(self, format: str, *args: object) -> None:
        """Not on the error stream."""


def test_a_network_camera_is_followed_until_it_breaks_off(tmp_path: Path) -> None:
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), _Camera) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_address[1]}/uav.mjpg"
        result = run_imager(tmp_path, address, "--no-bus", "--seconds", "0.5")
        broken = run_imager(tmp_path, address, "--no-bus")
        server.shutdown()
    assert result.code == 0, result.err
    assert "lost 0 times" in result.out
    assert broken.code == 2
    assert broken.err == f"imager: '{address}' gives no more pictures; check its cable or network, then start again.\n"


def test_a_sequence_of_pgm_pictures_is_read_to_its_end(tmp_path: Path) -> None:
    file = tmp_path / "two.pgm"
    file.write_bytes(b"P5\n# picture 7\n# exposure_us 1500\n2 2\n255\nabcdP5\n# exposure_us 21500\n1 1\n255\ne")
    with file.open("rb") as stream:
        first, second, third = (read_pgm(stream) for _ in range(3))
    assert first is not None and second is not None and third is None
    assert first.number == 7
    assert first.exposed_s == pytest.approx(1.5e-3)
    assert first.grey.tolist() == [[97, 98], [99, 100]]
    assert second.exposed_s == pytest.approx(21.5e-3)
    assert second.grey.tolist() == [[101]]
