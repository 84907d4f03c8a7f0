# SPDX-License-Identifier: Apache-2.0
"""Trajectories: read from files, interpolated, checked against limits. No device is needed."""

from __future__ import annotations

import itertools
import math
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from servoctl.drive.node_limits import Bound, NodeLimits
from servoctl.errors import InputError
from servoctl.motion import trajectory
from servoctl.motion.cable_wrap import with_turns
from servoctl.motion.trajectory import AxisLimits, Real, Trajectory, read_trajectory

WIDE = AxisLimits(NodeLimits(Bound(-3.0, "607D:1"), Bound(3.0, "607D:2"), Bound(1.0, "607F (57.3 °/s)")), 1.0, 0.5)


def written(folder: Path, text: str) -> Path:
    path = folder / "path.csv"
    path.write_text(text, encoding="utf-8")
    return path


def sine(step_s: float, rates: bool) -> Trajectory:
    time_s: Real = np.arange(0.0, 5.0, step_s, dtype=np.float64)
    angle, rate = 0.3 * np.sin(time_s), 0.3 * np.cos(time_s)
    used = rate if rates else np.gradient(angle, time_s, edge_order=2)
    return Trajectory(time_s, {0: angle}, {0: used}, [f"p:{i}" for i in range(len(time_s))])


def test_units_stand_in_the_titles_and_comments_are_skipped(tmp_path: Path) -> None:
    found = read_trajectory(written(tmp_path, "# made by hand\ntime_ms,pitch_mrad,pitch_rate_urad_s\n\n0,10,0\n500,20,1000\n"))
    assert found.time_s.tolist() == [0.0, 0.5] and list(found.angle_rad) == [1]
    assert found.angle_rad[1] == pytest.approx([0.01, 0.02])
    assert found.rate_rad_s[1] == pytest.approx([0.0, 0.001])
    assert found.places[1].endswith("path.csv:5")


@pytest.mark.parametrize("text, words", [
    ("time_s,azimuth_deg\n0,1\n", ("path.csv:2", "two rows")),
    ("", ("path.csv:1", "two rows")),
    ("time_s,azimuth\n0,1\n1,2\n", ("path.csv:1", "unknown column 'azimuth'", "azimuth_deg")),
    ("time_s,azimuth_deg,\n0,1,\n1,2,\n", ("path.csv:1", "column 3 has no title", "remove it from all rows")),
    ("azimuth_deg,pitch_deg\n0,1\n1,2\n", ("path.csv:1", "needs time_s")),
    ("time_s,azimuth_deg,azimuth_rad\n0,1,1\n1,2,2\n", ("path.csv:1", "two columns")),
    ("time_s,azimuth_deg,pitch_rate_deg_s\n0,1,1\n1,2,2\n", ("path.csv:1", "pitch has a rate but no angle")),
    ("time_s,azimuth_deg\n0,1\n1\n", ("path.csv:3", "1 values", "2 columns")),
    ("time_s,azimuth_deg\n0,1\n1,one\n", ("path.csv:3", "azimuth_deg is 'one'")),
    ("time_s,azimuth_deg\n0,1\n1,nan\n", ("path.csv:3", "azimuth_deg is 'nan'")),
    ("time_s,azimuth_deg\n0,1\n1,1_0\n", ("path.csv:3", "azimuth_deg is '1_0'")),
    ("time_s,azimuth_deg\n0,1\n1,1e300\n", ("path.csv:3", "azimuth_deg is '1e300'", "-1e+12 to 1e+12")),
    ("time_s,azimuth_deg\n0,1\n1,\"2\n", ("path.csv:3", "is not a row of a CSV file")),
    ("time_s,azimuth_deg\n0,1\n# again\n0,2\n", ("path.csv:4", "not after 0 s")),
])  # fmt: skip
def test_a_bad_file_is_refused_with_its_line(tmp_path: Path, text: str, words: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as refused:
        read_trajectory(written(tmp_path, text))
    assert all(word in str(refused.value) for word in words), refused.value


def test_what_is_no_file_or_too_large_is_refused_before_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="is not a file"):
        read_trajectory(Path("/dev/zero"))
    large = tmp_path / "large.csv"
    with large.open("wb") as file:
        file.truncate(210_000_000)
    with pytest.raises(InputError, match="has more than 200 MB"):
        read_trajectory(large)
    monkeypatch.setattr(trajectory, "MAX_ROWS", 2000)
    rows = "".join(f"{0.01 * row:.2f},0\n" for row in range(2001))
    with pytest.raises(InputError, match=r"path.csv:2002: a trajectory of more than 2000 rows"):
        read_trajectory(written(tmp_path, "time_s,azimuth_deg\n" + rows))


@pytest.mark.parametrize("rates", [False, True])
def test_a_row_takes_few_bytes_while_it_is_read_and_checked(tmp_path: Path, rates: bool) -> None:
    """10 min at 1 kHz are 600,000 rows: 105 s and 3.3 GB when each row had objects of its own, and each instant was looked at."""
    count = 50_000
    titles = "time_s,azimuth_deg,pitch_deg" + (",azimuth_rate_deg_s,pitch_rate_deg_s" if rates else "")
    tail = ",0,0" if rates else ""
    path = written(tmp_path, f"{titles}\n" + "".join(f"{1e-3 * i:.3f},{1e-5 * i:.6f},{2e-5 * i:.6f}{tail}\n" for i in range(count)))
    wide = {axis: AxisLimits(WIDE.node, 1e4, 1e4) for axis in range(2)}
    tracemalloc.start()
    found = with_turns(read_trajectory(path))[0]
    held = tracemalloc.get_traced_memory()[0] / count
    found.extended(1.0, 0.3).check(wide)
    most = tracemalloc.get_traced_memory()[1] / count
    tracemalloc.stop()
    assert held < 100 and most < 330  # in bytes
    assert found.places[count - 1].endswith(f"path.csv:{count + 1}")


def every_instant(path: Trajectory, limits: AxisLimits) -> int | None:
    """The first interval that breaks a limit at one of many instants."""
    u = np.linspace(0.0, 1.0, 33)
    for row, (t0, t1) in enumerate(itertools.pairwise(path.time_s)):
        one = Trajectory(path.time_s[row : row + 2], {0: path.angle_rad[0][row : row + 2]}, {0: path.rate_rad_s[0][row : row + 2]}, ["a", "b"])
        angle, rate = one.angles(0, t0 + u * (t1 - t0)), one.rates(0, t0 + u * (t1 - t0))
        acceleration = one._hermite(0, np.minimum(t0 + u * (t1 - t0), np.nextafter(t1, t0)), 2)
        most = np.where(acceleration * rate < 0.0, limits.deceleration_rad_s2, limits.acceleration_rad_s2)
        if (angle < limits.node.lowest.value).any() or (angle > limits.node.highest.value).any():
            return row
        if (np.abs(rate) > (1 + 1e-6) * limits.node.fastest.value).any() or (np.abs(acceleration) > (1 + 1e-6) * most).any():
            return row
    return None


def test_the_quick_check_finds_the_row_that_a_look_at_every_instant_finds() -> None:
    random = np.random.default_rng(5)
    rows = []
    for _ in range(300):
        time_s = np.cumsum(random.uniform(0.2, 2.0, 12))
        angle = np.cumsum(random.normal(0.0, 0.2, 12))
        path = Trajectory(time_s, {0: angle}, {0: random.normal(0.0, 0.2, 12)}, [str(i) for i in range(12)])
        scale = 10.0 ** random.uniform(0.0, 0.8)
        node = NodeLimits(Bound(-0.4 * scale, "607D:1"), Bound(0.4 * scale, "607D:2"), Bound(0.2 * scale, "607F"))
        limits = AxisLimits(node, 0.6 * scale, 0.9 * scale)
        found = path.first_violation({0: limits})
        rows.append(None if found is None else found[0])
        assert rows[-1] == every_instant(path, limits)
        looked = np.abs(path.rates(0, np.linspace(time_s[0], time_s[-1], 5001))).max()
        assert looked - 1e-12 <= path.fastest(0) < looked + 0.02
    assert len(set(rows)) > 8 and None in rows


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("rows", ["0,0\n1e-300,1\n", "0,0\n1e-320,1\n2e-320,0\n", "0,0\n1e-320,0\n1,0\n"])
def test_a_rate_that_is_no_number_is_beyond_every_limit(tmp_path: Path, rows: str) -> None:
    found = read_trajectory(written(tmp_path, "time_s,azimuth_deg\n" + rows))
    with pytest.raises(InputError, match=r"path.csv:\d"):
        found.check({0: WIDE})


def test_a_cubic_is_exact_with_rates_and_close_without() -> None:
    at = np.linspace(0.01, 4.7, 977)
    with_rates = np.abs(sine(0.2, True).angles(0, at) - 0.3 * np.sin(at)).max()
    without = np.abs(sine(0.2, False).angles(0, at) - 0.3 * np.sin(at)).max()
    assert with_rates < 0.3 * 0.2**4 / 384 * 1.05  # the error of cubic Hermite interpolation
    assert without < 5e-4
    cubic = Trajectory(np.array([0.0, 2.0]), {0: np.array([1.0, -1.0])}, {0: np.array([0.5, 0.25])}, ["a", "b"])
    t = np.array([0.5, 1.0, 1.5])
    c2, c3 = np.linalg.solve([[4.0, 8.0], [4.0, 12.0]], [-1.0 - 1.0 - 2 * 0.5, 0.25 - 0.5])
    assert cubic.angles(0, t) == pytest.approx(1.0 + 0.5 * t + c2 * t**2 + c3 * t**3)


def test_the_extension_starts_and_stops_at_the_given_acceleration() -> None:
    path = Trajectory(np.array([0.0, 1.0]), {0: np.array([0.0, 0.4])}, {0: np.array([0.4, 0.4])}, ["a", "b"])
    whole = path.extended(0.2, 0.3)
    assert whole.time_s.tolist() == pytest.approx([-2.3, -2.0, 0.0, 1.0, 3.0])
    at = np.array([-2.3, -2.1, -1.0, 0.5, 2.0, 3.0])
    assert whole.angles(0, at) == pytest.approx([-0.4, -0.4, -0.3, 0.2, 0.7, 0.8])
    whole.check({0: AxisLimits(WIDE.node, 0.2, 0.2)})
    with pytest.raises(InputError, match="start from rest.*6083"):
        whole.check({0: AxisLimits(WIDE.node, 0.19, 0.2)})
    with pytest.raises(InputError, match="stop after it.*6084"):
        whole.check({0: AxisLimits(WIDE.node, 0.2, 0.19)})


def test_the_first_row_that_breaks_a_limit_is_named_with_the_limit() -> None:
    path = sine(0.1, True)
    path.check({0: WIDE})
    for limits, row, word in (
        (AxisLimits(NodeLimits(Bound(-3.0, "607D:1"), Bound(0.2, "607D:2"), WIDE.node.fastest), 1.0, 1.0), 7, "607D:2"),
        (AxisLimits(NodeLimits(Bound(-0.1, "607D:1"), Bound(3.0, "607D:2"), WIDE.node.fastest), 1.0, 1.0), 34, "607D:1"),
        (AxisLimits(NodeLimits(WIDE.node.lowest, WIDE.node.highest, Bound(0.25, "607F")), 1.0, 1.0), 0, "607F"),
        (AxisLimits(WIDE.node, 1.0, 0.2), 7, "6084"),
        (AxisLimits(WIDE.node, 0.2, 1.0), 15, "6083"),
    ):
        with pytest.raises(InputError) as refused:
            path.check({0: limits})
        assert str(refused.value).startswith(f"p:{row}: at {0.1 * row:.6g} s azimuth") and word in str(refused.value)


def test_a_rate_between_two_rows_counts_too() -> None:
    """From rest to rest within 1 s: the mean rate is below the limit, the largest is 1.5 times that."""
    path = Trajectory(np.array([0.0, 1.0]), {1: np.array([0.0, 0.8])}, {1: np.zeros(2)}, ["first", "second"])
    with pytest.raises(InputError, match=r"first: at 0 s pitch would turn at 68\.7"):
        path.check({1: AxisLimits(WIDE.node, 9.0, 9.0)})


def test_ends_are_held() -> None:
    path = sine(0.1, True)
    assert path.angles(0, np.array([-5.0, 99.0])) == pytest.approx([0.0, 0.3 * math.sin(4.9)])
