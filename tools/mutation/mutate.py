# SPDX-License-Identifier: Apache-2.0
"""Mutation testing of firmware/: see tools/mutate --help."""

import argparse
import datetime
import fnmatch
import itertools
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from equivalent import LIST, Equivalents
from mutants import ROOT, Mutant, mutants_of
from programs import TRAPPED, Build, measure, run

HOST = ROOT / "build/host"
WORK = HOST / "mutation"
# Runs in the image only: main program and generated defaults; tests/target tests them on the emulated board.
IMAGE_ONLY = "firmware/products/"
TEST_SOURCES = ["firmware/*/tests/test_*.c", "hal/*/tests/test_*.c", "tests/store/test_*.c"]
KINDS = ["killed", "survived", "time-out", "equivalent"]
HELP = """\
Draws one-line mutants of the firmware (operators of universalmutator), and runs the C unit tests that contain the mutated
file, and the comparison of the printed descriptions with the committed ones (describe_node --check). A mutant that the
project's compiler flags refuse, or that gives the same object code at -O2, does not count. It is killed when a test
fails, also by undefined behaviour of the mutated file; a test that needs ten times its CPU time is a time-out. Equivalent mutants are listed with their reasons in
tools/mutation/equivalent.toml.

The score is killed / (killed + survived). A seed always draws the same mutants of a line, wherever the line moves. Without
--seed, the seed is today's date (UTC), so that each day draws mutants that the tests have not been written for."""


@dataclass
class Result:
    mutant: Mutant
    kind: str = ""
    objects: dict = field(default_factory=dict)  # source: the mutated object file
    reason: str = ""
    by: str = ""


def sources(patterns):
    """The files that are mutated: firmware's C files, lists of rows, and inline functions of headers."""
    found = [str(file.relative_to(ROOT)) for file in sorted(ROOT.glob("firmware/**/*.[ch]")) if file.parent.name != "tests"]
    found = [file for file in found if not file.startswith(IMAGE_ONLY)]
    if not patterns:
        return found
    chosen = []
    for pattern in patterns:
        pattern = pattern.rstrip("/")
        fitting = [file for file in found if fnmatch.fnmatch(file, pattern) or file.startswith(pattern + "/")]
        if not fitting:
            raise SystemExit(f"mutate: no file of the firmware fits \"{pattern}\"; give for example firmware/control or 'firmware/*/sdo*.c'")
        chosen += fitting
    return sorted(set(chosen))


def changed_files(base):
    """Files of the firmware that differ from where this branch left base, committed or not."""
    git = ["git", "-C", ROOT]
    start = subprocess.run([*git, "merge-base", "HEAD", base], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if start.returncode != 0:
        raise SystemExit(f"mutate: '{base}' is no commit with a common history: name one, for example --changed HEAD~3")
    names = subprocess.run([*git, "diff", "--name-only", start.stdout.strip(), "--", "firmware"], text=True, stdout=subprocess.PIPE, check=True)
    new = subprocess.run([*git, "ls-files", "--others", "--exclude-standard", "firmware"], text=True, stdout=subprocess.PIPE, check=True)
    return {name for name in (names.stdout + new.stdout).splitlines()}


def build_programs():
    tests = sorted(file.stem for pattern in TEST_SOURCES for file in ROOT.glob(pattern))
    for command in (["cmake", "--preset", "host"], ["cmake", "--build", "--preset", "host", "--target", *tests, "describe_node"]):
        done = subprocess.run(command, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if done.returncode != 0:
            raise SystemExit(f"mutate: the host build fails:\n{done.stdout[-4000:]}")
    build = Build(ROOT, HOST)
    return build, [build.program(name) for name in tests] + [build.program("describe_node", ["--check"])]


class Campaign:
    def __init__(self, build, programs):
        self.build, self.programs = build, programs
        self.originals = {}
        self.lock = threading.Lock()  # two mutants of a header need the same originals at once
        self.killers = Counter()  # (file, program): mutants

    def original(self, source):
        """The bytes of the object file without a mutant, made once."""
        with self.lock:
            if source not in self.originals:
                object_file = self.build.compile_to(source, {source: (ROOT / source).read_text()}, WORK / "original")
                self.originals[source] = object_file.read_bytes()
            return self.originals[source]

    def compile(self, result, folder):
        """Sets the object files that differ; none if the mutant does not count."""
        mutant = result.mutant
        text = mutant.apply((ROOT / mutant.file).read_text())
        affected = [mutant.file]
        if mutant.file.endswith(".h"):
            affected = sorted(file for file in self.build.dependents.get(mutant.file, ())
                              if file.startswith(("firmware/", "hal/")) and file.endswith(".c") and "/tests/" not in file
                              and not file.startswith(IMAGE_ONLY))
        for source in affected:
            object_file = self.build.compile_to(source, {mutant.file: text}, folder)
            if object_file is None:
                result.objects = {}
                return result
            if object_file.read_bytes() != self.original(source):
                result.objects[source] = object_file
            else:
                object_file.unlink()
        return result

    def order(self, mutant, programs):
        """First what killed most mutants of this file, then what is near to it, then what contains little and is fast."""
        folder, stem = str(Path(mutant.file).parent), Path(mutant.file).stem
        def distance(program):
            return (-self.killers[mutant.file, program.name], stem not in program.name,
                    not program.folder.startswith(folder), program.cpu_s > 0.5, len(program.objects))
        return sorted(programs, key=distance)

    def check_itself(self, results, folder):
        """Unchanged code must survive, or else this program finds kills that are none."""
        source = next((file for result in results for file in result.objects if file == result.mutant.file), None)
        if source:
            self.original(source)
            mutant = next(result.mutant for result in results if result.mutant.file == source)
            unchanged = Result(mutant, objects={source: WORK / "original" / Build.object_name(source)})
            if self.test(unchanged, folder, (ROOT / source).read_text()).kind != "survived":
                raise SystemExit(f"mutate: {unchanged.by} fails with the unchanged {source}: {unchanged.kind}")

    def test(self, result, folder, text=None):
        """Runs the programs until one fails; `text` is that of the mutated file."""
        folder.mkdir(parents=True, exist_ok=True)
        mutant = result.mutant
        text = text or mutant.apply((ROOT / mutant.file).read_text())
        header = mutant.file.endswith(".h")
        changed = {mutant.file: text}
        objects = {source: self.build.compile_to(source, changed, folder, TRAPPED) or file for source, file in result.objects.items()}
        inlined = self.build.dependents.get(mutant.file, set()) if header else set()
        programs = [program for program in self.programs
                    if program.objects & result.objects.keys() or self.build.outputs[program.own_object] in inlined]
        result.kind = "survived"
        for program in self.order(mutant, programs):
            binary = folder / program.name
            link = list(program.link)
            link[link.index("-o") + 1] = str(binary)
            at = link.index(program.own_object)
            own = self.build.outputs[program.own_object]
            replaced = []
            if own.endswith(".c") and own in inlined:
                object_file = self.build.compile_to(own, changed, folder, ["-O1"])
                if object_file is None:  # for example a static assertion of the test
                    result.kind = "refused"
                    break
                replaced = [str(object_file)]
            mutated = [str(file) for source, file in objects.items() if source in program.objects]
            link[at:at + 1] = [*(replaced or [program.own_object]), *mutated]
            linked = subprocess.run(link, cwd=self.build.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            if linked.returncode != 0:  # a mutant that takes away a function that other files need; a library may have the original
                if not any(words in linked.stdout for words in ("undefined reference", "multiple definition", "undefined symbol", "duplicate symbol")):
                    raise SystemExit(f"mutate: {program.name} cannot be linked:\n{linked.stdout[-2000:]}")
                result.kind = "refused"
                break
            outcome = run([binary, *program.arguments], ROOT, 1 + math.ceil(10 * program.cpu_s))
            binary.unlink()
            if outcome != "passed":
                result.kind, result.by = {"failed": "killed", "time-out": "time-out"}[outcome], program.name
                self.killers[mutant.file, program.name] += 1
                break
        return result


def draw(campaign, ordered, count, pool):
    """The first `count` mutants in order that compile to other object code."""
    WORK.mkdir(parents=True, exist_ok=True)
    base = Path(tempfile.mkdtemp(prefix="run-", dir=WORK))
    (base / "share").symlink_to(HOST / "share")  # where describe_node, in a folder of base, finds the plant
    results, refused = [], 0
    ordered = iter(enumerate(ordered))
    while len(results) < count:
        batch = list(itertools.islice(ordered, min(64, 2 * (count - len(results)))))
        if not batch:
            break
        for result in pool.map(lambda item: campaign.compile(Result(item[1]), base / str(item[0])), batch):
            if result.objects and len(results) < count:
                results.append(result)
            else:
                refused += not result.objects
    return base, results, refused


def report(results):
    folders = {}
    for result in results:
        parts = Path(result.mutant.file).parts
        folders.setdefault(parts[1], Counter())[result.kind] += 1
    rows = sorted(folders.items()) + [("all", sum(folders.values(), Counter()))]
    print(f"{'folder':<15}{'score':>8}" + "".join(f"{kind:>12}" for kind in KINDS))
    for name, counts in rows:
        print(f"{name:<15}{score(counts):>8}" + "".join(f"{counts[kind]:>12}" for kind in KINDS))


def score_of(counts):
    decided = counts["killed"] + counts["survived"]
    return 100.0 * counts["killed"] / decided if decided else None


def is_too_low(counts, minimum):
    """Whether a true score of `minimum` per cent would kill so few in less than 1 of 20 draws."""
    decided, share = counts["killed"] + counts["survived"], minimum / 100.0
    chance = sum(math.comb(decided, k) * share**k * (1.0 - share) ** (decided - k) for k in range(counts["killed"] + 1))
    return chance < 0.05


def score(counts):
    value = score_of(counts)
    return "-" if value is None else f"{value:.1f} %"


def diff(mutant):
    after = "".join(f"\n    + {line}" for line in mutant.after.split("\n"))
    return f"{mutant.file}:{mutant.line}\n    - {mutant.before}{after}"


def seed_of_today():
    return int(f"{datetime.datetime.now(datetime.UTC):%Y%m%d}")


def arguments():
    parser = argparse.ArgumentParser(prog="tools/mutate", description=HELP, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", type=int, default=1000, metavar="N", help="how many mutants; default 1000; 0: all")
    parser.add_argument("--seed", type=int, default=seed_of_today(), metavar="N",
                        help="which mutants; default: today's date, %(default)s")
    parser.add_argument("--files", nargs="+", default=[], metavar="FILE", help="only these files, folders or patterns")
    parser.add_argument("--changed", nargs="?", const="main", metavar="BASE",
                        help="only files of the firmware that changed since this branch left BASE (default: main)")
    parser.add_argument("--again", type=Path, metavar="FILE", help="only the survivors and time-outs that --json wrote to FILE")
    parser.add_argument("--minimum", type=float, metavar="PERCENT", help="fail if a true score of PERCENT would give one as low as this in less than 1 of 20 draws")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help="at once; default: one per processor")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write each mutant and its result to FILE")
    return parser.parse_args()


def main():
    options = arguments()
    print(f"seed {options.seed}", flush=True)
    files = sources(options.files)
    if options.changed:
        changed = changed_files(options.changed)
        files = [file for file in files if file in changed]
        if not files:
            print(f"No file of the firmware changed since {options.changed}.")
            return 0
    equivalents = Equivalents(LIST.read_text())
    build, programs = build_programs()
    campaign = Campaign(build, programs)
    by_file = {file: mutants_of(file, (ROOT / file).read_text()) for file in files}
    stale = [line for file in sorted({entry["file"] for entry in equivalents.entries}) if file in by_file or not (ROOT / file).exists()
             for line in equivalents.stale(file, by_file.get(file, []))]
    every = [mutant for mutants in by_file.values() for mutant in mutants if mutant.file.endswith(".h") or mutant.file in build.compile]
    if options.again:
        left = {(row["file"], row["before"], row["occurrence"], row["after"]) for row in json.loads(options.again.read_text())
                if row["result"] in ("survived", "time-out")}
        every = [mutant for mutant in every if (mutant.file, mutant.before, mutant.occurrence, mutant.after) in left]
        options.sample = 0
    every.sort(key=lambda mutant: mutant.rank(options.seed))
    for program in programs:  # before the mutants, because a test that fails anyway would end the run
        if program.objects & set(build.compiled_with(by_file)):
            program.cpu_s = measure([HOST / "bin" / program.name, *program.arguments], ROOT)
    with ThreadPoolExecutor(options.jobs) as pool:
        base, results, refused = draw(campaign, every, options.sample or len(every), pool)
        try:
            undecided = []
            for result in results:
                result.reason = equivalents.reason(result.mutant) or ""
                if result.reason:
                    result.kind = "equivalent"
                else:
                    undecided.append(result)
            campaign.check_itself(undecided, base / "unchanged")
            for number, _ in enumerate(pool.map(lambda item: campaign.test(item[1], base / f"test-{item[0]}"), enumerate(undecided)), 1):
                if sys.stderr.isatty():
                    print(f"\r{number} of {len(undecided)}", end="", file=sys.stderr)
        finally:
            shutil.rmtree(base)
    refused += sum(result.kind == "refused" for result in results)
    results = [result for result in results if result.kind != "refused"]
    for result in results:
        if result.kind == "time-out":
            print("time-out: " + diff(result.mutant) + f"    ({result.by})")
    for result in results:
        if result.kind == "survived":
            print("survived: " + diff(result.mutant))
    print(f"{len(results)} mutants of seed {options.seed} out of {len(every)}; {refused} drawn ones did not compile or gave the same object code.")
    report(results)
    if options.json:
        options.json.write_text(json.dumps([{"file": r.mutant.file, "line": r.mutant.line, "before": r.mutant.before,
                                             "occurrence": r.mutant.occurrence, "after": r.mutant.after,
                                             "result": r.kind, "by": r.by, "reason": r.reason} for r in results], indent=1))
    for line in stale:
        print(line)
    counts = Counter(result.kind for result in results)
    total = score_of(counts)
    low = options.minimum is not None and is_too_low(counts, options.minimum)
    if low:
        print(f"The score {total:.1f} % is below {options.minimum:g} %, and that is no chance: add a test for each survivor above, or remove the code that no test needs. "
              f"--seed {options.seed} draws these mutants again.")
    return 1 if stale or low else 0


if __name__ == "__main__":
    sys.exit(main())
