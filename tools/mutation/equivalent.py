# SPDX-License-Identifier: Apache-2.0
"""The list of equivalent mutants, equivalent.toml: those that no test can kill, each with its reason.

An entry is found by the file, the text of the line and, if given, that of the line before ("previous"), so that it
survives when the line moves. An entry whose line has gone, or that names a mutant which is not made of this line any
more, is stale and an error.
"""

import tomllib
from pathlib import Path

LIST = Path(__file__).with_name("equivalent.toml")


class Equivalents:
    def __init__(self, text):
        self.entries = tomllib.loads(text).get("equivalent", [])
        self.reasons = {}
        for entry in self.entries:
            missing = {"file", "line", "mutants", "reason"} - entry.keys()
            if missing:
                raise ValueError(f"equivalent.toml: the entry {entry} has no {', '.join(sorted(missing))}")
            for after in entry["mutants"]:
                self.reasons[entry["file"], entry["line"], after, entry.get("previous")] = entry["reason"]

    def reason(self, mutant):
        place = mutant.file, mutant.before, mutant.after
        return self.reasons.get((*place, mutant.previous)) or self.reasons.get((*place, None))

    def stale(self, file, mutants):
        """Entries of this file that fit none of its mutants."""
        known = {(mutant.before, mutant.after, previous) for mutant in mutants for previous in (None, mutant.previous)}
        return [f"{file}: \"{before}\" has no mutant \"{after}\"" + (f" after \"{previous}\"" if previous else "")
                + ": remove the entry from equivalent.toml"
                for (of, before, after, previous) in self.reasons if of == file and (before, after, previous) not in known]
