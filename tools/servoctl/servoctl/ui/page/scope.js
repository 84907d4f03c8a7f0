// SPDX-License-Identifier: Apache-2.0
// The scope of the device: signals captured in every tick around a trigger, whatever the bus carries.

import uPlot from "./uplot/uPlot.esm.js";
import { css } from "./plots.js";

const $ = (id) => document.getElementById(id);
const HEIGHT = 200;
const COLOURS = ["--azimuth", "--pitch", "--good", "--bad", "--demand", "--note", "--ink", "--accent"];
const FIRST = ["azimuth.rate", "azimuth.torque"];
const WITH_LEVEL = ["above", "below", "rising", "falling"];

export class Scope {
  constructor(ask) {
    this.ask = ask;
    this.plots = [];
    this.found = null;
    $("scope-arm").addEventListener("click", () => this.arm());
    $("scope-force").addEventListener("click", () => this.ask("scope_force"));
    $("scope-stop").addEventListener("click", () => this.ask("scope_stop"));
    $("scope-read").addEventListener("click", () => this.read());
    $("scope-save").addEventListener("click", () => this.save());
    $("scope-signals").addEventListener("change", () => this.choose());
    for (const id of ["scope-trigger", "scope-on"]) $(id).addEventListener("change", () => this.choose());
    new ResizeObserver(() => {
      for (const plot of this.plots) plot.setSize({ width: $("scope-plot").clientWidth, height: HEIGHT });
    }).observe($("scope-plot"));
  }

  // Reads the names once.
  async open() {
    if (this.names) return;
    this.names = await this.ask("scope_names");
    if (!this.names) return;
    $("scope-signals").replaceChildren(...this.names.signals.map(({ number, name }) => new Option(name, number, false, FIRST.includes(name))));
    $("scope-trigger").replaceChildren(...this.names.triggers.map((name) => new Option(name, name)));
    this.choose();
  }

  chosen() {
    const numbers = [...$("scope-signals").selectedOptions].map((option) => Number(option.value));
    return this.names.signals.filter(({ number }) => numbers.includes(number));
  }

  choose() {
    const chosen = this.chosen();
    const before = $("scope-on").value;
    $("scope-on").replaceChildren(...chosen.map(({ number, name }) => new Option(name, number)));
    if (chosen.some(({ number }) => String(number) === before)) $("scope-on").value = before;
    const on = chosen.find(({ number }) => String(number) === $("scope-on").value);
    $("scope-unit").textContent = on?.unit ?? "";
    for (const id of ["scope-on", "scope-level"]) $(id).disabled = !WITH_LEVEL.includes($("scope-trigger").value);
    const room = chosen.length ? this.names.words / chosen.length / 1000 : 0;
    $("scope-room").textContent = chosen.length > this.names.most ? `at most ${this.names.most} signals` : `${chosen.length} signals: room for ${room.toFixed(2)} s at 1000 Hz`;
  }

  async arm() {
    const number = (name) => $(`scope-${name}`).valueAsNumber;
    const signals = this.chosen().map(({ number: n }) => n);
    $("scope-note").textContent = "";
    await this.ask("scope_arm", { signals, rate_hz: number("rate"), duration_s: number("seconds"), pre_s: number("pre"), trigger: $("scope-trigger").value, on: Number($("scope-on").value), level: number("level") });
  }

  show(state, mayCommand) {
    const { scope } = state;
    const done = scope?.phase === "done";
    const texts = { idle: "", filling: "fills the time before the trigger", "waiting for the trigger": "waits for the trigger", triggered: "captures", done: "complete" };
    const text = scope ? `${texts[scope.phase] ?? scope.phase}${scope.phase === "triggered" ? ` ${scope.captured_s.toFixed(1)} s` : ""}` : "";
    if ($("scope-phase").textContent !== text) $("scope-phase").textContent = text;
    const moves = state.axes.some((axis) => axis.held);
    $("scope-arm").disabled = !mayCommand || !this.names;
    $("scope-force").disabled = !(mayCommand && scope && !done);
    $("scope-stop").disabled = !(mayCommand && scope && !done);
    $("scope-read").disabled = !(mayCommand && done);
    $("scope-save").disabled = !this.found;
    this.tried &&= done; // once: what refuses it stays for a while, and is said
    if (done && mayCommand && !moves && !this.reading && !this.tried) this.read();
    if (done && moves && !this.reading) $("scope-note").textContent = "it is read when both axes are off";
  }

  async read() {
    this.reading = true;
    this.tried = true;
    const found = await this.ask("scope_read");
    this.reading = false;
    if (!found) return;
    this.found = found;
    $("scope-note").textContent = `${found.time_s.length} frames every ${found.period_ms} ms${found.triggered ? "; the trigger is at 0 s" : "; without trigger"}`;
    this.draw();
  }

  draw() {
    for (const plot of this.plots) plot.destroy();
    $("scope-plot").replaceChildren();
    const units = [...new Set(this.found.signals.map((signal) => signal.unit))];
    this.plots = units.map((unit) => this.plot(unit));
  }

  plot(unit) {
    const chosen = this.found.signals.map((signal, n) => ({ ...signal, n })).filter((signal) => signal.unit === unit);
    const box = document.createElement("div");
    box.className = "plot";
    box.setAttribute("role", "img");
    box.setAttribute("aria-label", `capture, ${unit || "number"}: ${chosen.map((signal) => signal.name).join(", ")}`);
    $("scope-plot").append(box);
    const axis = { stroke: () => css("--quiet"), grid: { stroke: () => css("--line"), width: 1 }, ticks: { show: false }, font: "12px system-ui" };
    return new uPlot({
      width: $("scope-plot").clientWidth, height: HEIGHT, padding: [22, 10, 0, 0], cursor: { sync: { key: "scope" } },
      scales: { x: { time: false } },
      axes: [{ ...axis, size: 30, values: (_p, ticks) => ticks.map((t) => `${+t.toFixed(4)} s`) }, { ...axis, size: 60, label: unit || "number", labelSize: 18, labelFont: "12px system-ui" }],
      series: [{ label: "time", value: (_p, t) => (t === null ? "–" : `${t.toFixed(3)} s`) }, ...chosen.map((signal) => ({
        label: signal.name, stroke: () => css(COLOURS[signal.n % COLOURS.length]), width: 1.3, points: { show: false }, value: (_p, v) => (v === null || v === undefined ? "–" : `${v.toPrecision(5)} ${unit}`),
      }))],
      hooks: { draw: [(plot) => this.drawTrigger(plot)] },
    }, [this.found.time_s, ...chosen.map((signal) => signal.values)], box);
  }

  drawTrigger(plot) {
    if (!this.found.triggered) return;
    const { ctx, bbox } = plot;
    const x = plot.valToPos(0, "x", true);
    ctx.save();
    ctx.strokeStyle = css("--quiet");
    ctx.setLineDash([4, 3]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.restore();
  }

  save() {
    const { time_s: time, signals } = this.found;
    const lines = [["time_s", ...signals.map(({ name, unit }) => (unit ? `${name} (${unit})` : name))].join(",")];
    time.forEach((t, i) => lines.push([t.toFixed(4), ...signals.map(({ values }) => String(values[i]))].join(",")));
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([`${lines.join("\n")}\n`], { type: "text/csv" }));
    link.download = `scope-${new Date().toISOString().slice(0, 19).replaceAll(/[-:]/g, "")}Z.csv`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }
}
