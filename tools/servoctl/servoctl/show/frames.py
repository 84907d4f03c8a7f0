# SPDX-License-Identifier: Apache-2.0
"""Recordings and results as frames of pandas, which is optional (servoctl[frames]): indexed by time in s where there is one,
units in the names of the columns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..motion.tracking import STATES
from ..objects.parameter import AXES, Parameter, Value
from .recording import Recording, field_of

if TYPE_CHECKING:
    from pandas import DataFrame

    from ..gains.loop_test import MeasuredLoop
    from ..gains.tune_run import Proposal
    from ..identify.identified import Identified
    from ..motion.track_run import Record

TIME = "time_s"
_OF_A_CHECK = ("scenario", "case", "axis", "figure", "value", "scatter", "unit", "min", "max", "kept", "failure")


def need_pandas() -> None:
    """Call before a motion whose result is a frame. Raises InputError when pandas is not installed."""
    try:
        import pandas  # noqa: F401
    except ImportError as error:
        raise InputError("a frame needs the package pandas, which is not installed: install 'servoctl[frames]' or pandas.") from error


def recording_frame(recording: Recording) -> DataFrame:
    """A row per sample; azimuth_rate_deg_s and the like. A gap in the index is a gap in the stream."""
    values = recording.samples.values.astype("float64")
    return _indexed(TIME, recording.time_s, {field_of(signal): row for signal, row in zip(recording.signals, values, strict=True)})


def tracking_frame(record: Record) -> DataFrame:
    """A row per 10 ms: the error of each axis in rad (target minus line of sight), NaN while the axis did not follow, and its
    state. attrs: the frames of the camera that were taken, missed and dropped meanwhile."""
    columns: dict[str, Any] = {}
    for axis in record.axes:
        errors = record.errors[:, axis].copy()
        errors[~record.followed(axis)] = float("nan")
        columns[f"{AXES[axis]}_error_rad"] = errors
        columns[f"{AXES[axis]}_state"] = [STATES[state] for state in record.states_of(axis)]
    frame = _indexed(TIME, record.time_s(), columns)
    if record.frames is not None:
        frame.attrs |= {"taken": record.frames.taken, "missed": record.frames.missed, "dropped": record.frames.dropped}
    return frame


def parameter_frame(values: Mapping[Parameter, Value]) -> DataFrame:
    """A row per parameter, by name."""
    rows = {p.name: {"value": value, "unit": p.unit, "low": p.low, "high": p.high, "default": p.default, "object": p.where} for p, value in values.items()}
    return _by_name(rows, ("value", "unit", "low", "high", "default", "object"))


def proposal_frame(proposal: Proposal) -> DataFrame:
    """A row per gain that a design changes, by name."""
    rows = {p.name: {"before": proposal.present[p], "after": value, "unit": p.unit} for p, value in proposal.changed.items()}
    return _by_name(rows, ("before", "after", "unit"))


def estimates_frame(identified: Identified) -> DataFrame:
    """A row per identified parameter, by name."""
    rows = {
        name: {"value": e.value, "low": e.low, "high": e.high, "paper": e.paper, "unit": e.unit} for name, e in identified.estimates.items()
    }
    return _by_name(rows, ("value", "low", "high", "paper", "unit")).astype(dict.fromkeys(("value", "low", "high", "paper"), "float64"))


def loop_frame(measured: MeasuredLoop) -> DataFrame:
    """A row per sine."""
    columns = measured.columns()
    return _indexed("frequency_hz", columns.pop("frequency_hz"), columns)


def check_frame(figures: Iterable[Mapping[str, Any]]) -> DataFrame:
    """A row per figure of a check; `kept` is NA for a figure without a limit."""
    need_pandas()
    from pandas import DataFrame

    frame = DataFrame([{name: row[name] for name in _OF_A_CHECK} for row in figures], columns=list(_OF_A_CHECK))
    return frame.astype({"kept": "boolean", "value": "float64", "scatter": "float64", "min": "float64", "max": "float64"})


def _by_name(rows: Mapping[str, Mapping[str, Any]], columns: Sequence[str]) -> DataFrame:
    need_pandas()
    from pandas import DataFrame

    frame = DataFrame.from_dict(rows, orient="index", columns=list(columns))
    frame.index.name = "name"
    return frame


def _indexed(name: str, values: Any, columns: Mapping[str, Any]) -> DataFrame:
    need_pandas()
    from pandas import DataFrame, Index

    return DataFrame(columns, index=Index(values, name=name))
