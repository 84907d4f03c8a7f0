// SPDX-License-Identifier: Apache-2.0
// Present faults, the log, and the ticks before each fault.

function element(name, text = "", className = "") {
  return Object.assign(document.createElement(name), { textContent: text, className });
}

const DEGREES = 180 / Math.PI;
const SHOWN = { rad: ["°", DEGREES, 4], "rad/s": ["°/s", DEGREES, 4], "N m": ["N m", 1, 3], A: ["A", 1, 3], V: ["V", 1, 2] };

export function showFaults(place, note, found) {
  note.textContent = found.note;
  place.replaceChildren();
  const active = found.axes.filter((axis) => axis.code);
  if (!active.length) place.append(element("p", "No axis has a fault now."));
  for (const axis of active) {
    place.append(element("h3", `${axis.axis}: ${axis.meaning}`));
    for (const words of axis.faults) {
      for (const [title, text] of [["Detection", words.detection], ["Cause", words.cause], ["Check", words.check], ["Remedy", words.cure], ["Cleared by", words.clear]]) {
        if (text) place.append(element("p", `${title}: ${text}`));
      }
    }
  }
  if (found.log) showLog(place, found.log);
}

function showLog(place, log) {
  place.append(element("h3", log.entries.length ? `Fault log, newest first (${log.count} since it was cleared)` : "The fault log is empty."));
  for (const entry of log.entries) {
    const details = document.createElement("details");
    details.append(element("summary", `${entry.age_s.toFixed(1)} s ago  ·  ${entry.of}: ${entry.name}  ·  tick ${entry.tick}`));
    if (entry.samples.length) details.append(table(entry));
    place.append(details);
  }
}

function table(entry) {
  const box = element("div", "", "scroll");
  const found = document.createElement("table");
  const shown = entry.signals.map((signal) => SHOWN[signal.unit] ?? [signal.unit, 1, 3]);
  const head = found.createTHead().insertRow();
  for (const text of ["tick", ...entry.signals.map((signal, n) => `${signal.name.replaceAll("_", " ")} ${shown[n][0]}`)]) {
    head.append(Object.assign(element("th", text), { scope: "col" }));
  }
  const body = found.createTBody();
  entry.samples.forEach((sample, n) => {
    const row = body.insertRow();
    row.append(element("td", String(n - entry.samples.length + 1), "number"));
    sample.forEach((value, k) => row.append(element("td", value === null ? "–" : (value * shown[k][1]).toFixed(shown[k][2]), "number")));
  });
  box.append(found);
  return box;
}
