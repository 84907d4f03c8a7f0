// SPDX-License-Identifier: Apache-2.0
// Gain files: loaded and compared with the device, written to it, saved from it; and the values stored in its flash.

// A gains file has about 40 kB, in UTF-32 four times as much; the server closes the page for a message of more than 1 MiB.
const MOST_BYTES = 100000;
const $ = (id) => document.getElementById(id);

// The server decodes the text, as servoctl does with a file.
function base64(bytes) {
  return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
}

export class GainFile {
  constructor(ask, gains) {
    this.ask = ask;
    this.gains = gains;
    this.file = null;
    $("gain-file").addEventListener("change", () => this.load());
    $("gain-save").addEventListener("click", () => this.save());
    $("gain-store").addEventListener("click", () => this.store());
    $("compare-write").addEventListener("click", () => this.write());
    $("compare-close").addEventListener("click", () => this.close());
  }

  // `off`: no axis is enabled.
  enable(allowed, off) {
    this.allowed = allowed;
    $("gain-store").disabled = !allowed || !off;
    $("gain-store").title = off ? "" : "disable both axes first";
    $("compare-write").disabled = !allowed || !this.found?.different.length;
  }

  note(text) {
    $("gain-file-note").textContent = text;
  }

  async load() {
    const file = $("gain-file").files[0];
    if (!file) return;
    if (file.size > MOST_BYTES) {
      this.close();
      this.note(`${file.name} is no gains file: it has ${(file.size / 1000).toFixed(0)} kB, and at most ${MOST_BYTES / 1000} kB are read`);
      $("gain-file").value = "";
      return;
    }
    this.file = { name: file.name, base64: base64(new Uint8Array(await file.arrayBuffer())) };
    $("gain-file").value = "";
    await this.compare();
  }

  async compare() {
    this.close();
    const found = await this.ask("compare", this.file);
    if (!found) return;
    this.found = found;
    const count = found.different.length;
    $("compare-title").textContent = `${count} of ${found.compared} gains differ from ${found.name}`
      + (found.not_in_file ? `; ${found.not_in_file} gains of the device are not in it` : "");
    const warnings = [found.warning, found.staged.length ? `staged values of ${found.staged.join(" and ")} were compared; they are not active.` : ""];
    $("compare-warning").textContent = warnings.filter(Boolean).join(" ");
    $("compare-warning").hidden = !$("compare-warning").textContent;
    $("compare-table").tBodies[0].replaceChildren(...found.different.map((row) => {
      const line = document.createElement("tr");
      const cell = (text, className = "") => Object.assign(document.createElement("td"), { textContent: text, className });
      line.append(cell(`${row.name}${row.guarded ? " (guarded)" : ""}`), cell(row.device, "number"), cell(row.file, "number differs"), cell(row.unit));
      return line;
    }));
    $("gain-compare").hidden = false;
    this.enable(this.allowed, !$("gain-store").disabled);
  }

  async write() {
    const changes = await this.ask("restore", { ...this.file, ...this.gains.lock() });
    if (!changes) return;
    this.gains.edits.clear();
    await this.gains.read("");
    await this.compare();
    this.note(`${changes.length} gains written in one piece and read back`);
  }

  close() {
    this.found = null;
    $("gain-compare").hidden = true;
  }

  async save() {
    const found = await this.ask("save");
    if (!found) return;
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([found.text], { type: "application/toml" }));
    link.download = `gains-${new Date().toISOString().slice(0, 19).replaceAll(/[-:]/g, "")}Z.toml`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    this.note(`${found.count} gains saved`);
  }

  async store() {
    this.note("storing …");
    const backup = await this.ask("store");
    this.note(backup ? `stored in the device; backup: ${backup}` : "not stored");
    if (backup) this.gains.read("");
  }
}
