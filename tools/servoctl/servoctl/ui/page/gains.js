// SPDX-License-Identifier: Apache-2.0
// The gains of an axis: edits, and what the node has, beside each other.

const $ = (id) => document.getElementById(id);
const AXES = ["azimuth", "pitch"];

export class Gains {
  constructor(ask) {
    this.ask = ask;
    this.axis = 0;
    this.editsOf = [new Map(), new Map()];
    this.keys = [null, null];
    this.asked = false;
    this.done = ""; // what the page did last, until its user goes on
    this.allowed = false;
    this.onChange = () => {};
    $("gain-apply").addEventListener("click", () => this.apply());
    $("gain-clear").addEventListener("click", () => { this.edits.clear(); this.draw(); });
    $("gain-undo").addEventListener("click", () => this.undo());
    $("gain-read").addEventListener("click", () => this.read(""));
    $("gain-discard").addEventListener("click", async () => { await this.ask("discard", { axis: this.axis }); this.read(""); });
    $("gain-unlock").addEventListener("change", () => {
      $("gain-word-label").hidden = !this.unlocked;
      this.draw();
    });
    $("gain-filter").addEventListener("input", () => this.filter());
    for (const button of document.querySelectorAll("[data-gains]")) {
      button.addEventListener("click", () => {
        this.axis = Number(button.dataset.gains);
        for (const each of document.querySelectorAll("[data-gains]")) each.setAttribute("aria-pressed", String(each === button));
        this.read("");
      });
    }
  }

  // Of the shown axis; those of the other one stay.
  get edits() {
    return this.editsOf[this.axis];
  }

  get unlocked() {
    return $("gain-unlock").checked;
  }

  // What a request says about the access lock.
  lock() {
    return this.unlocked ? { unlock: true, word: $("gain-word").value } : {};
  }

  enable(allowed) {
    this.allowed = allowed;
    $("gain-apply").disabled = !allowed || !this.edits.size;
    $("gain-clear").disabled = !this.edits.size;
    $("gain-undo").disabled = !allowed;
    $("gain-discard").disabled = !allowed;
    for (const button of document.querySelectorAll("[data-gains]")) {
      const count = this.editsOf[Number(button.dataset.gains)].size;
      const text = `${AXES[Number(button.dataset.gains)]}${count ? ` (${count} new)` : ""}`;
      if (button.textContent !== text) button.textContent = text;
    }
  }

  // Another page or tool has changed a parameter set.
  follow(sets) {
    const key = JSON.stringify(sets[this.axis]);
    const changed = this.keys[this.axis] && sets[this.axis] && this.keys[this.axis] !== key;
    this.keys[this.axis] = key;
    if (changed) this.read();
  }

  async read(done = this.done) {
    this.asked = true;
    this.done = done;
    const found = await this.ask("gains", { axis: this.axis });
    if (found?.axis !== AXES[this.axis]) return; // another axis was chosen meanwhile
    this.found = found;
    this.draw();
    this.onChange();
  }

  async apply() {
    const edits = this.edits;
    const values = Object.fromEntries(edits);
    const changes = await this.ask("apply", { values, ...this.lock() });
    if (!changes) return;
    for (const [name, value] of Object.entries(values)) {
      if (edits.get(name) === value) edits.delete(name);
    }
    await this.read(`${changes.length} gain${changes.length > 1 ? "s" : ""} applied in one piece`);
  }

  async undo() {
    const changes = await this.ask("undo", this.lock());
    if (!changes) return;
    await this.read(`undone: ${changes.map((c) => c.name.split(".").at(-1).replaceAll("_", " ")).join(", ")}`);
  }

  draw() {
    if (!this.found) return;
    const { rows, staged, differs_from_stored: unsaved } = this.found;
    $("gain-staged").hidden = !staged;
    const present = unsaved ? "active values differ from the stored ones" : "as stored";
    $("gain-note").textContent = this.done ? `${this.done}; ${present}` : present;
    const body = [];
    let group = "";
    for (const row of rows) {
      if (row.group !== group) {
        group = row.group;
        const head = document.createElement("tr");
        head.className = "group";
        const title = Object.assign(document.createElement("th"), { textContent: group, colSpan: 7, scope: "colgroup" });
        head.append(title);
        body.push(head);
      }
      body.push(this.row(row, staged));
    }
    $("gains").tBodies[0].replaceChildren(...body);
    this.filter();
    this.enable(this.allowed);
  }

  row(row, staged) {
    const line = document.createElement("tr");
    line.dataset.name = row.name;
    const cell = (text, className = "number") => Object.assign(document.createElement("td"), { textContent: text, className });
    const input = Object.assign(document.createElement("input"), { value: this.edits.get(row.name) ?? row.value, inputMode: "decimal", readOnly: row.guarded && !this.unlocked, spellcheck: false });
    input.setAttribute("aria-label", `${row.group} ${row.entry}, ${row.unit || "number"}, ${row.range}`);
    input.classList.toggle("edited", this.edits.has(row.name));
    input.addEventListener("input", () => {
      if (input.value.trim() === row.value) this.edits.delete(row.name);
      else this.edits.set(row.name, input.value.trim());
      input.classList.toggle("edited", this.edits.has(row.name));
      this.enable(this.allowed);
    });
    input.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && this.edits.size && this.allowed) this.apply();
    });
    const help = () => {
      $("gain-help").textContent = `${row.name} (${row.where}): ${row.help}${row.guarded ? " Guarded: a wrong value can cause damage. Unlock it to change it, with both axes off." : ""} Default ${row.default} ${row.unit}.`;
    };
    input.addEventListener("focus", help);
    line.addEventListener("click", help);
    const field = document.createElement("td");
    field.append(input);
    line.append(
      cell(`${row.entry}${row.guarded ? " (guarded)" : ""}`, ""), field, cell(staged ? row.value : "–"),
      cell(row.active ?? "not known"), cell(row.stored ?? "not known", row.stored !== null && row.stored !== row.active ? "number differs" : "number"),
      cell(row.unit, ""), cell(row.range, "quiet"),
    );
    return line;
  }

  filter() {
    const wanted = $("gain-filter").value.trim().toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    let head = null;
    for (const line of $("gains").tBodies[0].rows) {
      if (line.classList.contains("group")) {
        if (head) head.hidden = !shown;
        head = line;
        shown = 0;
        continue;
      }
      const name = line.dataset.name.replaceAll("_", " ");
      line.hidden = !wanted.every((word) => name.includes(word));
      if (!line.hidden) shown += 1;
    }
    if (head) head.hidden = !shown;
  }
}
