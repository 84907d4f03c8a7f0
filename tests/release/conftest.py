# SPDX-License-Identifier: Apache-2.0
import subprocess
from pathlib import Path

import pytest
import releases


@pytest.fixture(scope="session")
def first(tmp_path_factory):
    """A clone with the version committed."""
    folder = releases.clone(releases.PROJECT, tmp_path_factory.mktemp("first") / "trackservo")
    releases.commit_version(folder)
    return folder


@pytest.fixture(scope="session")
def release(first):
    """Its release, of a tag."""
    releases.must(first, "git", "tag", f"v{releases.VERSION}")
    return releases.make(first)


@pytest.fixture(scope="session")
def second(first, release, tmp_path_factory):
    """The release of a clone at another place, without the tag."""
    folder = releases.clone(first, tmp_path_factory.mktemp("second") / "a folder with a longer name" / "clone")
    releases.must(folder, "git", "tag", "--delete", f"v{releases.VERSION}")
    return releases.make(folder)


@pytest.fixture(scope="session")
def unpacked(release, tmp_path_factory) -> Path:
    """The archives of programs, emulator and board, in one folder, as a user has them."""
    folder = tmp_path_factory.mktemp("unpacked")
    for kind in ("programs", "emulator", "flash"):
        (archive,) = release.glob(f"trackservo-{kind}-*.tar.gz")
        subprocess.run(["tar", "-xf", archive, "-C", folder], check=True)
    return folder


@pytest.fixture(scope="session")
def programs(unpacked) -> Path:
    """The folder bin."""
    (folder,) = unpacked.glob("trackservo-*-linux-*/bin")
    return folder


@pytest.fixture(scope="session")
def environment(release, tmp_path_factory) -> Path:
    """A Python environment with our wheels from the release's folder, and what they need from build/venv."""
    folder = tmp_path_factory.mktemp("environment")
    python = releases.PROJECT / "build/venv/bin/python"
    releases.must(folder, python, "-m", "venv", folder)
    site = Path(releases.must(folder, python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip())
    ours = Path(releases.must(folder, folder / "bin/python", "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip())
    pip = [folder / "bin/python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-index", "--no-deps"]
    releases.must(folder, *pip, *sorted(release.glob("*.whl")))
    # The packages alone: what is installed editable has a .pth there, which is not read.
    (ours / "others.pth").write_text(f"{site}\n")
    return folder / "bin"
