# SPDX-License-Identifier: Apache-2.0
"""Time that the follower takes for a picture of 640 x 480 pixels, by what it does: search, centroid, correlation tracker.

The target flies from sky into clutter, as in test_follower.py, 20 times. Not a test: prints milliseconds of this computer and
the ratio to the centroid.

    python -m tests.benchmark_follower
"""

from __future__ import annotations

import time

import numpy as np

from imager.follower import Follower, State

from .pictures import HEIGHT, Scene

FLIGHTS, PICTURES = 20, 60
HORIZON = HEIGHT // 2


def times_of(tracker: str) -> dict[str, list[float]]:
    """Milliseconds of each picture, by what the follower did."""
    times: dict[str, list[float]] = {"search": [], "centroid": [], tracker: []}
    for seed in range(FLIGHTS):
        follower, scene = Follower(tracker), Scene(seed, horizon=HORIZON)
        for i in range(PICTURES):
            picture = scene.picture(300.0 + i, 160.0 + 1.5 * i, -75.0)
            searched = follower.state is State.SEARCHING
            began = time.perf_counter()
            sighting = follower.take(picture)
            took_ms = 1e3 * (time.perf_counter() - began)
            times["search" if searched else tracker if sighting.by_correlation else "centroid"].append(took_ms)
    return times


def main() -> None:
    for tracker in ("kcf", "csrt"):
        times = times_of(tracker)
        centroid_ms = float(np.median(times["centroid"]))
        for name, taken_ms in times.items():
            if taken_ms:
                median_ms, most_ms = (float(np.percentile(taken_ms, share)) for share in (50, 95))
                print(
                    f"{tracker}: {name:<9} {len(taken_ms):5} pictures, median {median_ms:6.2f} ms, 95 % {most_ms:6.2f} ms,"
                    f" {median_ms / centroid_ms:5.1f} times the centroid"
                )


if __name__ == "__main__":
    main()
