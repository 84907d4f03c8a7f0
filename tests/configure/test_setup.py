# SPDX-License-Identifier: Apache-2.0
"""tools/setup on machines where something is missing; apt and dpkg are stand-ins."""

import os
import pathlib
import shutil
import subprocess

import pytest

PROJECT = pathlib.Path(__file__).resolve().parents[2]

# Every package is installed, except those in $MISSING.
DPKG_QUERY = """\
#!/bin/bash
[[ " $MISSING " == *" ${@: -1} "* ]] || echo -n installed
"""
APT_GET = """\
#!/bin/bash
echo "$*" >>"$(dirname "$0")/apt-calls"
exit 1
"""


@pytest.fixture
def project(tmp_path):
    """A copy of tools/setup and the files that it reads, without third_party and build."""
    (tmp_path / "tools").mkdir()
    for name in ("setup", "requirements.txt"):
        shutil.copy(PROJECT / "tools" / name, tmp_path / "tools")
    shutil.copytree(PROJECT / "tools/lib", tmp_path / "tools/lib")
    (tmp_path / "bin").mkdir()
    for name, text in (("dpkg-query", DPKG_QUERY), ("apt-get", APT_GET)):
        (tmp_path / "bin" / name).write_text(text)
        (tmp_path / "bin" / name).chmod(0o755)
    return tmp_path


def setup(project, mode, missing="", folder=None, **environment):
    plain = {name: value for name, value in os.environ.items() if name not in ("UNITY_DIR", "TRACKSERVO_PACKAGES")}
    path = {"PATH": f"{project / 'bin'}:{plain['PATH']}", "MISSING": missing}
    done = subprocess.run([project / "tools/setup", mode], cwd=folder or project, env=plain | path | environment,
                          capture_output=True, text=True)
    calls = project / "bin/apt-calls"
    return done, calls.read_text().splitlines() if calls.exists() else []


@pytest.mark.parametrize("place", [".", "src"])
def test_with_unity_dir_nothing_is_fetched(project, place):
    unity = project / "my unity"
    (unity / place).mkdir(parents=True)
    (unity / place / "unity.c").write_text("")
    for value in (str(unity), "my unity"):
        done, calls = setup(project, "firmware", UNITY_DIR=value)
        assert done.returncode == 0, done.stderr
        assert done.stdout == "Set-up for firmware: everything is installed.\n"
        assert not calls and not (project / "third_party").exists()


def test_without_unity_dir_unity_is_fetched(project):
    failed, calls = setup(project, "firmware")
    assert failed.returncode == 1
    assert "into third_party/unity" in failed.stdout
    assert "UNITY_DIR" in failed.stderr and any("ntpsec" in call or "update" in call for call in calls)


@pytest.mark.parametrize("mode", ["firmware", "board", "test"])
def test_a_unity_dir_without_unity_is_one_clear_error(project, mode):
    failed, calls = setup(project, mode, UNITY_DIR="nowhere")
    assert failed.returncode == 1 and not failed.stdout and not calls
    assert failed.stderr == (
        f"setup: there is no unity.c in UNITY_DIR ({project / 'nowhere'}): give the folder of Unity's unity.c and unity.h,"
        " or unset UNITY_DIR.\n"
    )


def test_the_firmware_needs_no_python_and_no_library_of_the_simulator(project):
    (project / "unity.c").write_text("")
    failed, _ = setup(project, "firmware", missing="gcc cmake g++ libeigen3-dev python3 gcc-arm-none-eabi", UNITY_DIR=".")
    assert failed.returncode == 1
    assert "  Debian packages, as root: cmake gcc\n" in failed.stdout
    assert "could not install the Debian packages cmake gcc (" in failed.stderr or "needs root" in failed.stderr


@pytest.mark.parametrize(("script", "tool", "word"), [
    ("tools/fuzz", "clang", "test"),
    ("tools/misra/check", "cppcheck", "test"),
])
def test_a_script_names_the_tool_that_it_misses_and_what_installs_it(tmp_path, script, tool, word):
    for name in ("bash", "dirname"):
        (tmp_path / name).symlink_to(shutil.which(name))
    failed = subprocess.run([PROJECT / script], env={"PATH": str(tmp_path)}, capture_output=True, text=True)
    name = pathlib.Path(script).name
    assert (failed.returncode, failed.stdout) == (1, "")
    assert failed.stderr == f"{name}: {tool} is missing: ./tools/setup {word} installs it.\n"


@pytest.mark.parametrize(("check", "tool"), [("check_format", "clang-format"), ("check_scripts", "shellcheck")])
def test_a_check_names_the_tool_that_it_misses(project, check, tool):
    for name in ("bash", "dirname"):
        (project / "bin" / name).symlink_to(shutil.which(name))
    script = f"source tools/lib/common.sh; source tools/lib/checks.sh; {check} x.c"
    failed = subprocess.run(["bash", "-c", script, "test"], cwd=project, env={"PATH": str(project / "bin")}, capture_output=True,
                            text=True)
    assert failed.returncode == 1
    assert failed.stderr == f"test: {tool} is missing: ./tools/setup test installs it.\n"
