# SPDX-License-Identifier: Apache-2.0
"""Recordings: what was written is read, in part too, from a file that was not ended, and never by waiting for the disk."""

from __future__ import annotations

import resource
import time
from pathlib import Path

import numpy as np
import pytest

from servoctl.errors import InputError
from servoctl.link.signal_stream import SETS, Samples
from servoctl.show import recording
from servoctl.show.recording import Recorder, read

SIGNALS = SETS["both"]
COUNT = 5000
CHUNK = 300
"""Samples that a chunk has at least."""


def samples(first: int, count: int) -> Samples:
    ticks = (np.arange(first, first + count) % (1 << 32)).astype(np.uint32)
    values = np.array([np.sin(0.01 * (n + 1) * np.arange(first, first + count)) for n in range(len(SIGNALS))], dtype=np.float32)
    return Samples(ticks, values)


def record(path: Path, *parts: Samples) -> Recorder:
    recorder = Recorder(path, SIGNALS, 1, {"serial": 7})
    for part in parts:
        recorder.add(part)
    recorder.close()
    return recorder


def test_all_samples_are_read_as_they_were_over_a_wrap_of_the_ticks_and_a_gap(tmp_path: Path) -> None:
    begin = (1 << 32) - 1000
    parts = samples(begin, COUNT), samples(begin + COUNT + 250, COUNT)
    assert record(tmp_path / "a.mcap", *parts).samples == 2 * COUNT
    found = read(tmp_path / "a.mcap")
    assert found.whole and found.signals == SIGNALS and found.period_ms == 1 and found.about == {"serial": "7"}
    assert np.array_equal(found.samples.ticks, np.concatenate([part.ticks for part in parts]))
    assert np.array_equal(found.samples.values, np.concatenate([part.values for part in parts], axis=1))
    assert found.time_s[0] == 0.0 and found.time_s[-1] == pytest.approx(0.001 * (2 * COUNT + 250 - 1))
    assert np.max(np.diff(found.time_s)) == pytest.approx(0.251)
    assert np.array_equal(found.column("azimuth rate"), found.samples.values[2])
    with pytest.raises(InputError, match="no signal 'x' in this recording; it has azimuth angle"):
        found.column("x")


def test_a_part_is_read(tmp_path: Path) -> None:
    record(tmp_path / "a.mcap", samples(0, COUNT))
    found = read(tmp_path / "a.mcap", from_s=1.0, seconds=0.5)
    assert found.samples.ticks.tolist() == list(range(1000, 1500)) and found.whole


def test_a_file_that_was_cut_is_read_up_to_the_cut(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    record(path, samples(0, COUNT))
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    found = read(path)
    assert not found.whole and 0.2 * COUNT < len(found.samples.ticks) < COUNT
    assert np.array_equal(found.samples.values, samples(0, len(found.samples.ticks)).values)


@pytest.mark.parametrize(("room", "least"), [(1000, 0), (50_000, 1), (200_000, 2 * CHUNK)])
def test_a_full_disk_ends_the_recording_and_what_it_says_is_readable(tmp_path: Path, room: int, least: int) -> None:
    """The largest file that this process may write ends a write as a full disk does."""
    path = tmp_path / "a.mcap"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, before[1]))
        recorder = record(path, *(samples(n, 500) for n in range(0, 20_000, 500)))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert "a.mcap: the recording has ended: File too large. " in recorder.error
    if least == 0:
        assert recorder.error.endswith("No sample was written before.") and recorder.samples == 0
        with pytest.raises(InputError, match="it has no samples"):
            read(path)
        return
    assert recorder.error.endswith(f"The {recorder.samples} samples written before are readable.")
    found = read(path)
    assert not found.whole and least <= recorder.samples <= len(found.samples.ticks) < 20_000
    assert np.array_equal(found.samples.values, samples(0, len(found.samples.ticks)).values)


def test_a_recording_that_goes_on_is_readable_up_to_its_last_second(tmp_path: Path) -> None:
    """As after its server was killed."""
    recorder = Recorder(tmp_path / "a.mcap", SIGNALS, 1, {})
    recorder.add(samples(0, COUNT))
    while recorder.samples < COUNT:
        time.sleep(0.01)
    time.sleep(0.1)
    assert COUNT - 1000 < len(read(tmp_path / "a.mcap").samples.ticks) < COUNT
    recorder.close()


def test_an_unexpected_error_ends_the_recording_with_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(self: Recorder, found: Samples) -> None:
        raise KeyError("a fault")

    monkeypatch.setattr(Recorder, "_write", fail)
    recorder = record(tmp_path / "a.mcap", samples(0, 10), samples(10, 10))
    assert recorder.error.endswith(
        "the recording has ended: internal error of servoctl: KeyError('a fault'). No sample was written before."
    )


@pytest.mark.parametrize("content", [b"", b"not a recording", b"\x89MCAP0\r\n"])
def test_what_is_no_recording_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(InputError, match="not a recording of servoctl"):
        read(tmp_path / "a.mcap")
    with pytest.raises(InputError, match="cannot be read"):
        read(tmp_path / "b.mcap")


def test_only_names_of_recordings_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SERVOCTL_STATE", str(tmp_path))
    record(recording.folder() / "a.mcap", samples(0, 10))
    assert recording.find("a.mcap").is_file()
    for name in ("../a.mcap", "b.mcap", "a", "", "/etc/passwd"):
        with pytest.raises(InputError, match="no recording"):
            recording.find(name)
    with pytest.raises(InputError, match="cannot be written"):
        Recorder(recording.folder() / "a.mcap", SIGNALS, 1, {})
