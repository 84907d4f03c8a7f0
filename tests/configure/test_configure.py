# SPDX-License-Identifier: Apache-2.0
"""Configuring with a missing part: one helpful sentence, and the part is used once it is installed."""

import os
import pathlib
import re
import shutil
import subprocess

import pytest

PROJECT = pathlib.Path(__file__).resolve().parents[2]
WITHOUT_COMPILERS = ("cmake", "ninja")
C_ONLY = (*WITHOUT_COMPILERS, "gcc", "as", "ld", "ar", "ranlib")  # no g++, no Python, no git


def path_with(folder, names):
    """A PATH with these programs only."""
    folder.mkdir()
    for name in names:
        (folder / name).symlink_to(shutil.which(name))
    return str(folder)


@pytest.fixture
def bare_path(tmp_path):
    return path_with(tmp_path / "bin", WITHOUT_COMPILERS)


def run(folder, *command, **environment):
    left_out = ("UNITY_DIR", "CC", "CXX", "CMAKE_C_COMPILER_LAUNCHER", "CMAKE_CXX_COMPILER_LAUNCHER")
    plain = {name: value for name, value in os.environ.items() if name not in left_out}
    return subprocess.run(command, cwd=folder, env=plain | environment, capture_output=True, text=True)


def errors(result):
    """What CMake calls errors, each on one line."""
    return [" ".join(text.split()) for text in re.split(r"^CMake Error", result.stderr, flags=re.MULTILINE)[1:]]


def setup_words():
    """The arguments of tools/setup, from "Usage: tools/setup [demo|test]"."""
    return re.findall(r"\w+", run(PROJECT, "tools/setup", "--help").stdout.splitlines()[0].split("[")[1])


@pytest.fixture
def sources(tmp_path):
    """The image's sources, in their own folder: presets build below it."""
    folder = tmp_path / "sources"
    folder.mkdir()
    for name in ("CMakeLists.txt", "CMakePresets.json"):
        shutil.copy(PROJECT / name, folder)
    for name in ("cmake", "firmware", "hal"):
        shutil.copytree(PROJECT / name, folder / name)
    return folder


MISSING = [
    ("firmware", ("cmake",), "Ninja (ninja)", "firmware"),
    ("firmware", WITHOUT_COMPILERS, "The C compiler (gcc)", "firmware"),
    ("host", WITHOUT_COMPILERS, "The C compiler (gcc)", "firmware"),
    ("host", C_ONLY, "The C++ compiler (g++)", "demo"),
    ("host-fuzz", C_ONLY, "The compiler for the fuzzers (clang)", "test"),
]


@pytest.mark.parametrize(("preset", "programs", "name", "word"), MISSING)
def test_without_a_build_tool_one_sentence_says_what_installs_it(sources, tmp_path, preset, programs, name, word):
    path = path_with(tmp_path / "bin", programs)
    for _ in range(2):  # what the first try leaves behind adds nothing
        failed = run(sources, "cmake", "--preset", preset, PATH=path)
        (reported,) = errors(failed)
        assert f"{name} is missing: ./tools/setup {word} installs it." in reported
        assert word in setup_words()


def test_without_the_emulator_of_the_core_one_sentence_says_what_installs_it(sources, tmp_path):
    cross = [f"arm-none-eabi-{tool}" for tool in ("gcc", "as", "ld", "ar", "ranlib", "objcopy", "objdump", "size", "nm")]
    hidden = "-DCMAKE_IGNORE_PATH=/bin;/usr/bin;/usr/local/bin"  # CMake looks there beside the PATH
    path = path_with(tmp_path / "bin", (*WITHOUT_COMPILERS, *cross))
    failed = run(sources, "cmake", "--preset", "cortex-m4-qemu", hidden, PATH=path)
    (reported,) = errors(failed)
    assert "The emulator of the board's core (qemu-system-arm) is missing: ./tools/setup test installs it." in reported


def test_the_firmware_needs_gcc_ninja_and_unity_only(sources, tmp_path):
    shutil.copytree(PROJECT / "tests", sources / "tests", ignore=shutil.ignore_patterns("corpus"))
    (tmp_path / "unity.c").write_text("")
    path = path_with(tmp_path / "bin", C_ONLY)
    options = ["-DCMAKE_DISABLE_FIND_PACKAGE_Python3=ON", f"-DUNITY_DIR={tmp_path}"]
    done = run(sources, "cmake", "--preset", "firmware", *options, PATH=path)
    assert done.returncode == 0, done.stderr
    built = run(sources, "cmake", "--build", "--preset", "firmware", "--target", "trackservo_base", "trackservo_hal_host", PATH=path)
    assert built.returncode == 0, built.stdout


@pytest.mark.parametrize("preset", ["stm32g474", "cortex-m4-qemu"])
def test_without_the_cross_compiler_one_sentence_says_what_installs_it(sources, bare_path, preset):
    for _ in range(2):  # what the first try leaves behind adds nothing
        failed = run(sources, "cmake", "--workflow", "--preset", preset, PATH=bare_path)
        assert failed.returncode != 0
        (message,) = errors(failed)
        assert "The compiler for the board (arm-none-eabi-gcc) is missing" in message
        command = re.search(r"\./tools/setup (\w+) installs it\.", message)
        assert command, message
        assert command[1] in setup_words()


def test_a_cross_compiler_that_has_been_installed_since_is_used(sources, bare_path):
    assert run(sources, "cmake", "--preset", "stm32g474", PATH=bare_path).returncode != 0
    done = run(sources, "cmake", "--preset", "stm32g474")
    assert done.returncode == 0, done.stderr


USES_UNITY = """
cmake_minimum_required(VERSION 3.25)
project(uses_unity C)
add_library(trackservo_sanitizers INTERFACE)
include(TrackservoUnity)
message(STATUS "unity of ${unity_source_dir}")
"""


@pytest.fixture
def uses_unity(tmp_path):
    """Configures a project without its own Unity; returns where it found one, or its message."""
    folder = tmp_path / "uses_unity"
    folder.mkdir()
    (folder / "CMakeLists.txt").write_text(USES_UNITY)

    def configure(*options, **environment):
        found = run(folder, "cmake", "-G", "Ninja", "-B", "build", f"-DCMAKE_MODULE_PATH={PROJECT / 'cmake'}", *options,
                    **environment)
        place = re.search(r"^-- unity of (.*)$", found.stdout, re.MULTILINE)
        return pathlib.Path(place[1]) if place else errors(found)

    return configure


@pytest.fixture
def copies(tmp_path):
    """Two folders with a unity.c."""
    folders = [tmp_path / name for name in ("one", "two")]
    for folder in folders:
        folder.mkdir()
        (folder / "unity.c").write_text("")
    return folders


def test_a_relative_unity_dir_counts_from_the_project_folder(uses_unity, copies):
    one, _ = copies
    assert uses_unity(UNITY_DIR=f"../{one.name}") == one


def test_unity_dir_of_the_environment_counts_after_a_first_try_without_it(uses_unity, copies):
    one, two = copies
    (message,) = uses_unity()
    assert "Unity, the C test framework (no unity.c in" in message and "third_party/unity" in message
    assert "is missing: ./tools/setup firmware installs it." in message
    assert uses_unity(UNITY_DIR=str(one)) == one
    assert uses_unity() == one  # as when a build configures again by itself
    assert uses_unity(UNITY_DIR=str(two)) == two


def test_an_option_counts_before_the_environment(uses_unity, copies):
    one, two = copies
    assert uses_unity(f"-DUNITY_DIR={one}", UNITY_DIR=str(two)) == one
    assert uses_unity("-DUNITY_DIR=", UNITY_DIR=str(two)) == two


# Each library or tool that a CMake module searches: its name for the user, what hides it, the module, and the argument
# of tools/setup that installs it.
HIDDEN = {
    "Eigen": ("-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON", "TrackservoDependencies", "demo"),
    "toml++": ("-DCMAKE_DISABLE_FIND_PACKAGE_tomlplusplus=ON", "TrackservoDependencies", "demo"),
    "nlohmann_json": ("-DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON", "TrackservoDependencies", "demo"),
    "{fmt}": ("-DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON", "TrackservoDependencies", "demo"),
    "Boost": ("-DCMAKE_DISABLE_FIND_PACKAGE_Boost=ON", "TrackservoDependencies", "demo"),
    "CLI11": ("-DCMAKE_DISABLE_FIND_PACKAGE_CLI11=ON", "TrackservoDependencies", "demo"),
    "pugixml": ("-DCMAKE_DISABLE_FIND_PACKAGE_pugixml=ON", "TrackservoDependencies", "demo"),
    "NLopt": ("-DCMAKE_IGNORE_PATH=/usr/include;/usr/local/include", "TrackservoDependencies", "demo"),
    "Python 3.11": ("-DCMAKE_DISABLE_FIND_PACKAGE_Python3=ON", "TrackservoImage", "board"),
    "Unicorn": ("-DX=", "TrackservoUnicorn", "test"),  # searched only below the project's own folder
    "pytest": ("-DX=", "TrackservoPytest", "test"),
}


@pytest.mark.parametrize("name", HIDDEN)
def test_what_is_missing_is_the_one_error_and_says_what_installs_it(tmp_path, name):
    hidden, module, word = HIDDEN[name]
    (tmp_path / "CMakeLists.txt").write_text(f"cmake_minimum_required(VERSION 3.25)\nproject(p CXX)\ninclude({module})\n")
    failed = run(tmp_path, "cmake", "-B", "build", f"-DCMAKE_MODULE_PATH={PROJECT / 'cmake'}", hidden)
    (reported,) = errors(failed)
    assert name in reported and f" is missing: ./tools/setup {word} installs it." in reported
    assert word in setup_words()
