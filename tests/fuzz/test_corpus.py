# SPDX-License-Identifier: Apache-2.0
"""The corpus archives of tests/fuzz/corpus, and how tools/fuzz handles them; the fuzzers themselves are stand-ins."""

from __future__ import annotations

import gzip
import os
import re
import shutil
import subprocess
import tarfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CORPUS = ROOT / "tests" / "fuzz" / "corpus"

# A run finds one input. A merge copies the contents of the second folder into the first, as libFuzzer does with new
# coverage.
FUZZER = """\
#!/bin/bash
folders=("${@: -2}")
if [[ " $* " == *" -merge=1 "* ]]; then
  cp "${folders[1]}"/* "${folders[0]}"
else
  echo "new input" >"${folders[0]}/found"
  echo "INFO: cov: 7"
  echo "Done 100 runs in 0 second(s)"
fi
"""


def targets() -> list[str]:
    printed = subprocess.run([ROOT / "tools/fuzz", "--help"], capture_output=True, text=True, check=True).stdout
    return re.findall(r"^  ((?:\w+ )+\w+)$", printed, re.MULTILINE)[0].split()


def shell(command: str, *arguments: Path) -> None:
    """Runs a function of tools/lib/fuzz_corpus.sh."""
    library = ROOT / "tools/lib/fuzz_corpus.sh"
    subprocess.run(["bash", "-euc", f'source "{library}"; {command} "$@"', "bash", *arguments], check=True)


def inputs(archive: Path) -> dict[str, bytes]:
    with tarfile.open(archive) as packed:
        return {entry.name: packed.extractfile(entry).read() for entry in packed}  # type: ignore[union-attr]


def test_each_fuzzer_has_one_archive_and_nothing_else_is_there():
    assert sorted(path.name for path in CORPUS.iterdir()) == sorted(f"{target}.tar.gz" for target in targets())


@pytest.mark.parametrize("target", targets())
def test_packing_what_was_unpacked_gives_the_archive_again(target, tmp_path):
    archive = CORPUS / f"{target}.tar.gz"
    shell("unpack_corpus", archive, tmp_path / "unpacked")
    assert len(inputs(archive)) >= 20
    shell("pack_corpus", tmp_path / "unpacked", tmp_path / "again.tar.gz")
    assert gzip.decompress((tmp_path / "again.tar.gz").read_bytes()) == gzip.decompress(archive.read_bytes())


def test_order_time_and_rights_of_the_inputs_change_no_byte(tmp_path):
    for folder, names in (("one", ["a", "b", "c"]), ("two", ["c", "a", "b"])):
        (tmp_path / folder).mkdir()
        for age, name in enumerate(names):
            file = tmp_path / folder / name
            file.write_text(name)
            file.chmod(0o600 if folder == "one" else 0o755)
            os.utime(file, (age, age))
        shell("pack_corpus", tmp_path / folder, tmp_path / f"{folder}.tar.gz")
    assert (tmp_path / "one.tar.gz").read_bytes() == (tmp_path / "two.tar.gz").read_bytes()


@pytest.fixture
def project(tmp_path):
    """A copy of tools/fuzz and of one corpus, with a stand-in for the fuzzer and for CMake."""
    for name in ("tools/fuzz", "tests/fuzz/corpus/sdo_server.tar.gz"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    shutil.copytree(ROOT / "tools/lib", tmp_path / "tools/lib")
    for name, text in (("bin/cmake", "#!/bin/bash\n"), ("build/host-fuzz/bin/fuzz_sdo_server", FUZZER)):
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        file.chmod(0o755)
    return tmp_path


def fuzz(project: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PATH": f"{project / 'bin'}:{os.environ['PATH']}"}
    return subprocess.run([project / "tools/fuzz", *arguments], env=environment, capture_output=True, text=True, check=False)


def test_keep_adds_new_inputs_to_the_archive(project):
    archive = project / "tests/fuzz/corpus/sdo_server.tar.gz"
    before = inputs(archive)
    done = fuzz(project, "--runs", "100", "--keep", "sdo_server")
    assert done.returncode == 0, done.stderr
    assert f"sdo_server: {len(before)} inputs, 100 executions without a finding, 7 edges" in done.stdout
    assert f"sdo_server: 1 new inputs in tests/fuzz/corpus/sdo_server.tar.gz, {len(before) + 1} in all" in done.stdout
    assert inputs(archive) == before | {"found": b"new input\n"}


def test_a_run_without_keep_leaves_the_archive_as_it_is(project):
    archive = project / "tests/fuzz/corpus/sdo_server.tar.gz"
    before = archive.read_bytes()
    for arguments in (["--short"], ["--runs", "100"]):
        assert fuzz(project, *arguments, "sdo_server").returncode == 0
    assert archive.read_bytes() == before


def test_short_with_keep_is_refused(project):
    refused = fuzz(project, "--short", "--keep")
    assert refused.returncode == 1
    assert refused.stderr == "fuzz: --short and --keep exclude each other, because --short stores no inputs.\n"
