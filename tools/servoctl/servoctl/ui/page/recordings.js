// SPDX-License-Identifier: Apache-2.0
// Recordings of the live signals: begun and ended, listed, opened in the plots of the live view, and downloaded.

import { History } from "./history.js";

const $ = (id) => document.getElementById(id);

export class Recordings {
  constructor(ask, plots, complain) {
    this.ask = ask;
    this.plots = plots;
    this.complain = complain;
    $("record").addEventListener("click", () => this.toggle());
    $("recording-close").addEventListener("click", () => this.close());
    $("recordings-read").addEventListener("click", () => this.list());
  }

  show(state, mayCommand) {
    const { recording, stream } = state;
    this.running = Boolean(recording);
    this.period = stream.period_ms || this.period;
    $("record").disabled = !(mayCommand && (recording || stream.period_ms));
    $("record").textContent = recording ? "End recording" : "Record";
    $("record").setAttribute("aria-pressed", String(this.running));
    const text = !recording ? "" : recording.error || `${recording.name}: ${(recording.samples * this.period / 1000).toFixed(0)} s`;
    if ($("record-note").textContent !== text) $("record-note").textContent = text;
  }

  async toggle() {
    await this.ask(this.running ? "end_recording" : "record");
    this.list();
  }

  async list() {
    const answer = await fetch("recordings").catch(() => undefined); // the page says by itself that its server is lost
    if (!answer?.ok) return;
    const rows = (await answer.json()).map(({ name, bytes, time }) => {
      const row = document.createElement("tr");
      const cell = (content, className = "") => {
        const found = Object.assign(document.createElement("td"), { className });
        found.append(content);
        return found;
      };
      const open = Object.assign(document.createElement("button"), { type: "button", textContent: "Open" });
      open.setAttribute("aria-label", `Open ${name}`);
      open.addEventListener("click", () => this.open(name));
      const link = Object.assign(document.createElement("a"), { href: `recordings/${name}`, download: name, textContent: "Download" });
      row.append(cell(name), cell(new Date(1000 * time).toLocaleString()), cell(`${(bytes / 1e6).toFixed(2)} MB`, "number"), cell(open), cell(link));
      return row;
    });
    $("recordings").tBodies[0].replaceChildren(...rows);
    $("recordings-note").textContent = rows.length ? "" : "no recordings yet";
  }

  // Ten minutes from a time on.
  async open(name) {
    const answer = await fetch(`recordings/${name}/samples?from=${Math.max(0, Number($("recording-from").value) || 0)}`).catch(() => undefined);
    if (!answer) return;
    if (!answer.ok) {
      this.complain(new Error(await answer.text()));
      return;
    }
    const buffer = await answer.arrayBuffer();
    const length = new DataView(buffer).getUint32(0, true);
    const about = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    const samples = buffer.slice(4 + length);
    const count = new DataView(samples).getUint32(0, true);
    if (!count) {
      this.complain(new Error(`${name} has no samples from ${$("recording-from").value} s on.`));
      return;
    }
    const history = new History(about.signals, about.period_ms, count);
    history.add(samples);
    this.plots.open(about.signals, history);
    $("recording-shown").hidden = false;
    $("recording-title").textContent = `${name}, ${history.end.toFixed(1)} s from ${new Date(about.begun).toLocaleString()}${about.whole ? "" : "; it was not ended, and is shown up to the last whole part"}`;
  }

  close() {
    this.plots.close();
    $("recording-shown").hidden = true;
  }
}
