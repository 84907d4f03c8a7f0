# SPDX-License-Identifier: Apache-2.0
"""No command replaces a file of the user, unless --overwrite asks for it, and none replaces what it reads."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from servoctl.cli import servoctl
from servoctl.commands.motion import new_path
from servoctl.errors import InputError
from servoctl.gains import tune_run
from servoctl.identify import identification
from servoctl.objects.fault_log import FaultLog, LogEntry, snapshot_files
from servoctl.show.output_files import check_new, unused

from .conftest import Bench

MINE = "mine"
NOWHERE = "slcan-tcp:127.0.0.1:9"
"""Nobody listens: what is refused is refused before that."""
PATH = "time_s,azimuth_deg\n0,1\n5,2\n"

OUTPUTS: dict[tuple[str, str], tuple[tuple[str, ...], tuple[str, ...]]] = {
    ("save", "file"): (("save", "x.toml"), ("x.toml",)),
    ("log", "file"): (("log", "--out", "x.csv"), ("x.csv",)),
    ("follow", "plot"): (("follow", "path.csv", "--plot", "x.png"), ("x.png", "x.csv")),
    ("track", "plot"): (("track", "--plot", "x.svg"), ("x.svg", "x.csv")),
    ("identify", "folder"): (
        ("identify", "--axis", "pitch", "--out", "found"),
        tuple(str(path) for path in identification.result_files(Path("found"), 1)),
    ),
    ("tune", "folder"): (
        ("tune", "--axis", "pitch", "--from", "found"), tuple(str(path) for path in tune_run.result_files(Path("found"), 1)),
    ),
}  # fmt: skip
"""Options and arguments that name files to be written: the command, and the files."""
NEW_NAMES = {("bode", "folder"), ("step", "folder"), ("scope", "folder"), ("braking", "folder")}
"""Options of folders in which every call writes files with new names."""
AFTER_READING = {("faults", "folder")}
"""Options of folders in which the names depend on the device."""
INPUTS = {("diff", "file"), ("restore", "file"), ("follow", "file"), ("identify", "program"), ("tune", "program")}


def bench_at(folder: Path) -> Bench:
    (folder / "path.csv").write_text(PATH)
    (folder / "found").mkdir()
    return Bench(NOWHERE, folder)


def path_options(command: click.Command, words: tuple[str, ...] = ()) -> Iterator[tuple[str, str]]:
    """Command and name of all parameters that are paths, except the common one of the description."""
    if isinstance(command, click.Group):
        for name, inner in command.commands.items():
            yield from path_options(inner, (*words, name))
        return
    for parameter in command.params:
        if isinstance(parameter.type, click.Path) and parameter.name != "parameters":
            yield " ".join(words), str(parameter.name)


def test_every_option_that_names_a_file_is_in_a_list_of_this_test() -> None:
    assert set(path_options(servoctl)) == {*OUTPUTS, *NEW_NAMES, *AFTER_READING, *INPUTS}


@pytest.mark.parametrize("words, files", OUTPUTS.values(), ids=[" ".join(key) for key in OUTPUTS])
def test_a_file_that_exists_stays_and_the_sentence_names_it(tmp_path: Path, words: tuple[str, ...], files: tuple[str, ...]) -> None:
    bench = bench_at(tmp_path)
    assert "exists already" not in bench(*words).err
    for file in files:
        path = tmp_path / file
        path.write_text(MINE)
        refused = bench(*words)
        assert refused.code == 2 and f"'{file}' exists already" in refused.err and refused.err.count("\n") == 1, refused
        assert "--overwrite" in refused.err and path.read_text() == MINE
        allowed = bench(*words, "--overwrite")
        assert "exists already" not in allowed.err and path.read_text() == MINE, allowed  # there is no bus
        path.unlink()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["found", "path.csv"]


@pytest.mark.parametrize("plot", ["path.png", "./path.pdf", "found/../path.svg", "PATH"])
@pytest.mark.parametrize("more", [(), ("--overwrite",), ("--overwrite", "--dry-run")])
def test_what_is_followed_is_never_replaced_by_the_numbers_of_the_plot(tmp_path: Path, plot: str, more: tuple[str, ...]) -> None:
    bench = bench_at(tmp_path)
    if plot == "PATH":  # another name of the same file
        os.link(tmp_path / "path.csv", tmp_path / "other.csv")
        plot = "other.png"
    refused = bench("follow", "path.csv", "--plot", plot, *more)
    assert refused.code == 2 and "this command reads it" in refused.err and refused.err.count("\n") == 1
    assert (tmp_path / "path.csv").read_text() == PATH


def test_the_description_of_the_device_is_never_replaced(tmp_path: Path) -> None:
    bench = bench_at(tmp_path)
    description = Path(bench.environment["SERVOCTL_PARAMETERS"])
    (tmp_path / "copy.json").write_bytes(description.read_bytes())
    before = description.read_bytes()
    for words in (("--out", str(description)), ("--out", "copy.json", "--parameters", "copy.json")):
        refused = bench("log", *words, "--overwrite")
        assert refused.code == 2 and "this command reads it" in refused.err
    assert description.read_bytes() == before == (tmp_path / "copy.json").read_bytes()


def test_a_folder_in_place_of_the_file_is_refused_before_anything_moves(tmp_path: Path) -> None:
    bench = bench_at(tmp_path)
    (tmp_path / "x.csv").mkdir()
    for more in ((), ("--overwrite",)):
        refused = bench("follow", "path.csv", "--plot", "x.png", *more)
        assert refused.code == 2 and "'x.csv' cannot be written: it is a folder" in refused.err


def test_devices_and_pipes_are_no_files_of_the_user() -> None:
    check_new([Path("/dev/null")], False, "--out")


def test_the_files_of_faults_are_all_written_or_none(tmp_path: Path) -> None:
    entry = LogEntry(100, 1.0, 2, "encoder jump", "pitch", (("rate", "rad/s"),), ((0.1,),))
    board = LogEntry(100, 1.0, 2, "RAM parity", "board", (), ())
    files = list(snapshot_files(FaultLog(3, (entry, board, entry)), tmp_path))
    assert [path.name for path in files] == ["fault-1-pitch-encoder-jump.csv", "fault-3-pitch-encoder-jump.csv"]
    check_new(files, False, "--csv")
    files[1].write_text(MINE)
    with pytest.raises(InputError, match="--csv: .*fault-3-pitch-encoder-jump.csv' exists already"):
        check_new(files, False, "--csv")
    check_new(files, True, "--csv")


def test_measurements_of_the_same_second_get_names_of_their_own(tmp_path: Path) -> None:
    found = set()
    for _ in range(3):
        path = new_path(tmp_path, "step", "pitch")
        found.add(path)
        path.with_suffix(".csv").write_text(MINE)
    assert len(found) == 3
    assert unused(tmp_path / "a.v2.png", ".csv").name == "a.v2.png"
    (tmp_path / "a.v2.csv").write_text(MINE)
    assert unused(tmp_path / "a.v2.png", ".csv").name == "a.v2-2.png"


def test_save_and_log_replace_a_file_when_asked(servo: Bench) -> None:
    servo.json("save", "x.toml")
    text = (servo.folder / "x.toml").read_text().replace("# Gains,", "# My gains,", 1)
    (servo.folder / "x.toml").write_text(text)
    assert servo("save", "x.toml").code == 2 and (servo.folder / "x.toml").read_text() == text
    servo.json("save", "x.toml", "--overwrite")
    assert "# My gains," in (servo.folder / "x.toml").read_text()
    assert sorted(path.name for path in servo.folder.glob("x*")) == ["x.toml"]
    words = ("log", "azimuth.statusword", "--rate", "50", "--for", "0.1", "--out", "x.csv")
    assert servo(*words).code == 0
    before = (servo.folder / "x.csv").read_text()
    assert servo(*words).code == 2 and (servo.folder / "x.csv").read_text() == before
    assert servo(*words, "--overwrite").code == 0


def test_a_log_without_rows_leaves_the_file_of_before(tmp_path: Path) -> None:
    bench = bench_at(tmp_path)
    (tmp_path / "x.csv").write_text(MINE)
    assert bench("log", "azimuth.statusword", "--out", "x.csv", "--overwrite").code == 3
    assert (tmp_path / "x.csv").read_text() == MINE
