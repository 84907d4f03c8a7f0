"""Trajectories: read from files, interpolated, checked against limits. No device is needed."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from servoctl.errors import InputError
from servoctl.node_limits import Bound, NodeLimits
from servoctl.trajectory import AxisLimits, Real, Trajectory, read_trajectory

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


def test_what_is_no_file_or_too_large_is_refused_before_it_is_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is not a file"):
        read_trajectory(Path("/dev/zero"))
    large = tmp_path / "large.csv"
    with large.open("wb") as file:
        file.truncate(60_000_000)
    with pytest.raises(InputError, match="has 60 MB; at most 50 MB"):
        read_trajectory(large)
    rows = "".join(f"{0.01 * row:.2f},0\n" for row in range(200_001))
    with pytest.raises(InputError, match=r"path.csv:200001: the trajectory has 200001 rows; at most 199999"):
        read_trajectory(written(tmp_path, "time_s,azimuth_deg\n" + rows))


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
