# SPDX-License-Identifier: Apache-2.0
"""The host build as tools/mutate uses it: how each file is compiled, and what each test is linked from."""

import json
import os
import re
import resource
import shlex
import signal
import subprocess
import tempfile
import threading
from dataclasses import dataclass, field
from pathlib import Path

ARCHIVE_MEMBER = re.compile(r"^(?:\S*/)?lib(\w+)\.a\(([^)]+)\.o\)")
# Not in the object file that is compared, or slower than needed.
DROPPED_FLAGS = {"-g1", "-g"}
# Undefined behaviour stops the program, as in the step asan of tools/test: an index beyond its array often changes no result.
TRAPPED = ["-fsanitize=undefined", "-fsanitize-undefined-trap-on-error"]
FAILED_ASSERTION = b":FAIL"  # as Unity prints it


@dataclass
class Program:
    """A test: a program that fails when the code is wrong."""
    name: str
    link: list  # the command; its output is the program's path in the build
    arguments: list
    folder: str  # of its source, from the project's folder
    own_object: str  # the test's own object file
    objects: set = field(default_factory=set)  # sources in it
    cpu_s: float = 0.0


class Build:
    def __init__(self, root, folder):
        self.root, self.folder = root, folder
        self.compile = {}  # source from the project's folder: its command, without -c, -o and the source
        self.outputs = {}  # object file: source
        for entry in json.loads((folder / "compile_commands.json").read_text()):
            words = shlex.split(entry["command"])
            output = words[words.index("-o") + 1]
            source = self._relative(entry["file"])
            flags = words[:words.index("-o")]
            self.compile.setdefault(source, [flag for flag in flags if flag not in DROPPED_FLAGS])
            self.outputs[output] = source
        self.dependents = self._dependents()

    def _relative(self, path):
        path = Path(path)
        return str(path.relative_to(self.root)) if path.is_relative_to(self.root) else str(path)

    def _dependents(self):
        """For each header, the sources that include it."""
        found, source = {}, None
        for line in self._ninja("-t", "deps").splitlines():
            if line and not line.startswith(" "):
                source = self.outputs.get(line.split(":")[0])
            elif line.strip() and source:
                found.setdefault(self._relative((self.folder / line.strip()).resolve()), set()).add(source)
        return found

    def _ninja(self, *arguments):
        return subprocess.run(["ninja", "-C", self.folder, *arguments], check=True, text=True, stdout=subprocess.PIPE).stdout

    def compiled_with(self, files):
        """The sources whose object files a change of these files can change."""
        return {source for file in files for source in {file} | self.dependents.get(file, set())}

    def program(self, name, arguments=()):
        """Links the program once more for its link map."""
        line = [line for line in self._ninja("-t", "commands", f"bin/{name}").splitlines() if f"-o bin/{name} " in line][-1]
        link = shlex.split(line.removeprefix(": && ").removesuffix(" && :"))
        objects = [word for word in link if word.endswith(".o")]
        own = self.outputs[objects[0]]
        program = Program(name, link, list(arguments), str(Path(own).parent), objects[0])
        program.objects = {self.outputs[word] for word in objects} | self._members(link)
        return program

    def _members(self, link):
        members = {}
        for output, source in self.outputs.items():
            parts = re.match(r".*CMakeFiles/(\w+)\.dir/(?:.*/)?([^/]+)\.o$", output)
            if parts:  # else a precompiled header
                members[parts[1], parts[2]] = source
        command = [word for word in link if word != "-fuse-ld=mold"]  # the map is read in GNU ld's form
        with tempfile.TemporaryDirectory() as folder:
            map_file = Path(folder) / "link.map"
            command[command.index("-o") + 1] = str(map_file.with_suffix(".out"))
            subprocess.run([*command, f"-Wl,-Map={map_file}"], check=True, cwd=self.folder)
            lines = map_file.read_text().splitlines()
        found = (ARCHIVE_MEMBER.match(line) for line in lines)
        return {members[match[1], match[2]] for match in found if match and (match[1], match[2]) in members}

    @staticmethod
    def object_name(source):
        return source.replace("/", "_") + ".o"

    def compile_to(self, source, text_of, folder, optimise=()):
        """Compiles a source into folder, with the files of text_of in the place of the project's own. None: refused."""
        for name, text in text_of.items():
            file = folder / "source" / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        output = folder / self.object_name(source)
        place = folder / "source" if source in text_of else self.root
        shadow = folder / "source" / "firmware"
        command = [self.compile[source][0], f"-I{shadow}", *self.compile[source][1:], *optimise, "-c", str(place / source), "-o", str(output)]
        done = subprocess.run(command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return output if done.returncode == 0 else None


def run(command, cwd, cpu_limit_s):
    """"passed", "failed" or "time-out". Ends at the first failed assertion: a mutant that fails one test may keep the next
    one busy for ever. CPU time counts, so that a loaded machine changes nothing; a program that waits for ever ends after
    ten times as long."""
    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (cpu_limit_s, cpu_limit_s + 1))
        resource.setrlimit(resource.RLIMIT_AS, (2**32, 2**32))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    process = subprocess.Popen(["stdbuf", "-oL", *command], cwd=cwd, preexec_fn=limit, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    late = threading.Event()

    def end():
        late.set()
        process.kill()
    timer = threading.Timer(10 * cpu_limit_s + 10, end)
    timer.start()
    failed = False
    with process.stdout:
        for line in process.stdout:
            if FAILED_ASSERTION in line:
                failed = True
                process.kill()
                break
    code = process.wait()
    timer.cancel()
    if failed:
        return "failed"
    if late.is_set() or code in (-signal.SIGXCPU, -signal.SIGKILL):
        return "time-out"
    return "passed" if code == 0 else "failed"


def measure(command, cwd):
    """The CPU time of a program that passes."""
    process = subprocess.Popen(command, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    with process.stdout:
        text = process.stdout.read()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"mutate: {Path(command[0]).name} fails without a mutant:\n{text}")
    return used.ru_utime + used.ru_stime
