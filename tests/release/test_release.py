# SPDX-License-Identifier: Apache-2.0
"""What `tools/release` makes: the same bytes from two clones, no path of the machine, and all of it works where a user puts it."""

from __future__ import annotations

import json
import re
import subprocess
import tarfile
import zipfile

import fmpy
import pytest
from releases import PROJECT, VERSION, must, run

SYSTEM = {"libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}


def names(folder):
    return sorted(file.name for file in folder.iterdir())


def test_two_clones_in_different_folders_give_the_same_bytes(release, second):
    assert names(release) == names(second)
    differing = [name for name in names(release) if (release / name).read_bytes() != (second / name).read_bytes()]
    assert differing == []


def test_the_sums_are_those_of_all_files(release):
    must(release, "sha256sum", "--check", "--quiet", "--strict", "SHA256SUMS")
    listed = {line.split()[1] for line in (release / "SHA256SUMS").read_text().splitlines()}
    assert listed == set(names(release)) - {"SHA256SUMS"}


def test_no_file_names_a_folder_of_this_machine(release, first, unpacked):
    folders = [str(first), str(PROJECT), str(first.parents[1])]
    for file in [file for folder in (release, unpacked) for file in folder.rglob("*") if file.is_file()]:
        content = file.read_bytes()
        assert not [folder for folder in folders if folder.encode() in content], file
    for packed in (*release.glob("*.whl"), *release.glob("*.fmu")):
        with zipfile.ZipFile(packed) as archive:
            for name in archive.namelist():
                assert not [folder for folder in folders if folder.encode() in archive.read(name)], (packed, name)


def test_the_programs_need_only_what_they_bring_and_glibc(programs):
    brought = set(names(programs.parent / "lib"))
    for program in programs.iterdir():
        dynamic = must(programs, "readelf", "--dynamic", "--wide", program)
        needed = set(re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic))
        assert needed <= brought | SYSTEM, program
        assert set(re.findall(r"\((?:RUNPATH|RPATH)\).*\[(.*)\]", dynamic)) <= {"$ORIGIN/../lib"}, program
    assert "NEEDED" not in must(programs, "readelf", "--dynamic", "--wide", programs / "identify")


def test_the_units_run_and_need_only_glibc(release, tmp_path):
    """tests/fmi says that they are right; here, that those of the release are whole."""
    units = sorted(release.glob("*.fmu"))
    assert [unit.name.split("-")[1] for unit in units] == ["plant", "servo"]
    for unit in units:
        folder = tmp_path / unit.stem
        fmpy.extract(str(unit), str(folder))
        (library,) = folder.glob("binaries/*/*.so")
        assert set(re.findall(r"\(NEEDED\).*\[(.*)\]", must(folder, "readelf", "--dynamic", "--wide", library))) <= SYSTEM
        assert (folder / "documentation/licenses/README.txt").read_text().count("\n") > 5
        found = fmpy.simulate_fmu(str(unit), stop_time=0.01, output_interval=1e-3, output=["bus_voltage_v"])
        assert found["bus_voltage_v"][-1] > 10.0


def test_the_programs_find_their_data_wherever_they_are(programs, tmp_path):
    moved = programs.parent.rename(programs.parent.with_name("elsewhere"))
    try:
        assert must(tmp_path, moved / "bin/sim_host", "--version") == f"sim_host {VERSION}\n"
        done = run(tmp_path, moved / "bin/sim_host", "check", "--seeds", "1")
        assert done.returncode in (0, 1) and done.stderr.count("warning") == 1, done.stderr  # of the one seed
    finally:
        moved.rename(programs.parent)


@pytest.fixture
def serving(programs, tmp_path):
    """Starts a program with these words; gives the bus that it serves. Both end with the test."""
    started = []

    def serve(program, *words):
        process = subprocess.Popen(
            [programs / program, *map(str, words), "--until-stdin-ends", "--bus", "slcan-tcp:0"],
            cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        started.append(process)
        return process.stdout.readline().strip()

    yield serve
    for process in started:
        process.stdin.close()
        process.wait(20)


def test_servoctl_of_the_wheel_plans_an_identification_with_the_program_of_the_other(environment, serving, tmp_path):
    assert must(tmp_path, environment / "servoctl", "--version") == f"servoctl {VERSION}\n"
    assert must(tmp_path, environment / "imager", "--version") == f"imager {VERSION}\n"
    assert must(tmp_path, environment / "trackservo-identify", "--version") == f"identify {VERSION}\n"
    bus = serving("sim_host", "serve")
    said = must(
        tmp_path, environment / "servoctl", "identify", "--axis", "azimuth", "--travel-deg", "-150", "150", "--dry-run",
        PATH="/usr/bin:/bin", SERVOCTL_BUS=bus,
    )  # fmt: skip
    assert "run" in said


def test_the_released_image_runs_on_the_released_emulator(environment, serving, release, tmp_path):
    (image,) = release.glob("*-nucleo_g474.bin")
    bus = serving("emulate_board", "serve", "--image", image)
    info = json.loads(must(tmp_path, environment / "servoctl", "info", "--json", SERVOCTL_BUS=bus))
    assert VERSION in json.dumps(info)


def test_the_image_keeps_its_budget(release):
    (report,) = release.glob("*-nucleo_g474.size.txt")
    assert "heap: none" in report.read_text() and "OVER" not in report.read_text()


def test_the_flash_kit_does_what_the_checkout_does(unpacked, first):
    (kit,) = unpacked.glob("trackservo-flash-*")
    for runner in ("openocd", "stlink", "dfu"):
        said = must(kit, "tools/image/board", "--dry-run", runner, "flash", "trackservo")
        there = must(first, "tools/image/board", "--dry-run", runner, "flash", kit / "trackservo")
        assert said.replace(str(kit), "HERE") == there.replace(f"{kit}/trackservo", "trackservo").replace(str(first), "HERE")
    assert (kit / "licenses/README.txt").read_text().count("\n") > 2


def test_each_wheel_is_typed_and_has_its_licences(release):
    for wheel in release.glob("*.whl"):
        with zipfile.ZipFile(wheel) as archive:
            inside = archive.namelist()
        assert any(name.endswith("/py.typed") for name in inside), wheel
        assert any(name.endswith("licenses/LICENSE") for name in inside), wheel
    assert len(list(release.glob("*-none-any.whl"))) == 2 and len(list(release.glob("*-manylinux*.whl"))) == 1


def test_requirements_and_list_of_parts_have_every_package_with_its_hash(release):
    wanted = (release / "requirements-imager.txt").read_text()
    pinned = dict(re.findall(r"^([\w.-]+)==(\S+)", wanted, re.MULTILINE))
    assert {"servoctl", "trackservo-identify", "trackservo-imager", "canopen", "numpy", "av"} <= set(pinned)
    assert not {"pytest", "mypy"} & set(pinned)
    assert all(f"{name}=={version}" in wanted and "--hash=sha256:" in wanted for name, version in pinned.items())
    parts = json.loads((release / "sbom.cdx.json").read_text())
    listed = {part["name"].lower() for part in parts["components"]}
    assert {"eigen", "unicorn", "uplot", "newlib", "canopen", f"trackservo-{VERSION}-nucleo_g474.bin"} <= listed
    assert parts["metadata"]["component"]["version"] == VERSION


def test_the_sources_are_those_of_the_commit(release, first):
    with tarfile.open(release / f"trackservo-{VERSION}-sources.tar.gz") as archive:
        packed = {name.partition("/")[2] for name, member in ((m.name, m) for m in archive) if not member.isdir()}
    assert packed == set(must(first, "git", "ls-files").split("\n")) - {""}
