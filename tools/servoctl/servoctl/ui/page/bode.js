// SPDX-License-Identifier: Apache-2.0
// The speed loop in the frequency domain: measured last, the one before it, and the one that the present gains would have.

import uPlot from "./uplot/uPlot.esm.js";
import { css, logTicks } from "./plots.js";
import { confirmPlan } from "./plan.js";

const $ = (id) => document.getElementById(id);
const PLOTS = [
  { kind: "open loop gain", unit: "dB", height: 240, of: (r) => [r.open_frequency_hz, r.open_db] },
  { kind: "open loop phase", unit: "°", height: 200, of: (r) => [r.open_frequency_hz, r.open_deg] },
  { kind: "closed loop gain", unit: "dB", height: 180, of: (r) => [r.closed_frequency_hz, r.closed_db] },
];
const STYLES = {
  measured: { stroke: () => css("--azimuth"), width: 1.8 },
  before: { stroke: () => css("--pitch"), width: 1.2, dash: [6, 4] },
  "present gains": { stroke: () => css("--demand"), width: 1.2, dash: [2, 3] },
};

export class Bode {
  constructor(ask) {
    this.ask = ask;
    this.results = [];
    this.predicted = null;
    this.plots = [];
    $("bode-go").addEventListener("click", () => this.measure());
    $("bode-axis").addEventListener("change", () => {
      this.results = [];
      this.predicted = null;
      this.draw();
    });
    new ResizeObserver(() => {
      for (const { plot, height } of this.plots) plot.setSize({ width: $("bode-plot").clientWidth, height });
    }).observe($("bode-plot"));
  }

  enable(allowed) {
    $("bode-go").disabled = !allowed;
  }

  get axis() {
    return Number($("bode-axis").value);
  }

  async measure() {
    const number = (name) => $(`bode-${name}`).valueAsNumber;
    const values = { axis: this.axis, low_hz: number("low"), high_hz: number("high"), bias_deg_s: number("bias"), amplitude_deg_s: number("amplitude"), periods: number("periods") };
    const plan = await this.ask("plan_bode", values);
    if (!plan || !(await confirmPlan(plan))) return;
    $("bode-note").textContent = "the axis moves …";
    const result = await this.ask("bode", values);
    $("bode-note").textContent = result ? `measured; ${result.trusted} of ${result.lines} lines with good coherence, ${result.lost} samples lost` : "not measured";
    if (!result) return;
    this.results = [result, ...this.results].slice(0, 2);
    this.predicted = null;
    this.draw();
  }

  // Call when gains have changed.
  async predict() {
    if (!this.results.length) return;
    this.predicted = (await this.ask("predict", { axis: this.axis })) ?? null;
    this.draw();
  }

  curves() {
    const [last, before] = this.results;
    return [["measured", last], ["before", before], ["present gains", this.predicted]].filter(([, result]) => result);
  }

  draw() {
    for (const { plot } of this.plots) plot.destroy();
    $("bode-plot").replaceChildren();
    this.table();
    this.plots = this.curves().length ? PLOTS.map((each) => this.plot(each)) : [];
  }

  table() {
    const at = (value, places, unit, where) => (value === null || value === undefined ? "outside" : `${value.toFixed(places)} ${unit}${where === undefined ? "" : ` at ${where.toFixed(1)} Hz`}`);
    $("bode-table").tBodies[0].replaceChildren(...this.curves().map(([name, result]) => {
      const m = result.margins;
      const row = document.createElement("tr");
      const texts = [name, at(m.phase_margin_deg, 1, "°", m.crossover_hz ?? undefined), at(m.gain_margin_db, 1, "dB", m.phase_crossover_hz ?? undefined),
        at(m.sensitivity, 2, ""), result.closed_db ? at(result.bandwidth_hz, 1, "Hz") : "–", result.closed_db ? at(result.closed_peak_db, 1, "dB") : "–"];
      row.append(...texts.map((text, n) => Object.assign(document.createElement("td"), { textContent: text, className: n ? "number" : "" })));
      return row;
    }));
  }

  // The same frequencies in all plots.
  range() {
    const all = this.results.flatMap((result) => result.closed_frequency_hz);
    return [Math.min(...all), Math.max(...all)];
  }

  plot({ kind, unit, height, of }) {
    const curves = this.curves().filter(([, result]) => of(result)[0]);
    const data = uPlot.join(curves.map(([, result]) => of(result)));
    const box = document.createElement("div");
    box.className = "plot";
    box.setAttribute("role", "img");
    box.setAttribute("aria-label", `${kind} over frequency, ${unit}`);
    $("bode-plot").append(box);
    const axis = { stroke: () => css("--quiet"), grid: { stroke: () => css("--line"), width: 1 }, ticks: { show: false }, font: "12px system-ui" };
    const plot = new uPlot({
      width: $("bode-plot").clientWidth, height, padding: [22, 10, 0, 0], cursor: { sync: { key: "bode" } },
      scales: { x: { time: false, distr: 3, range: () => this.range() } },
      axes: [{ ...axis, size: 30, values: (_p, ticks) => logTicks(ticks).map((text) => (text ? `${text} Hz` : "")) },
        { ...axis, size: 60, label: `${kind}  ${unit}`, labelSize: 18, labelFont: "12px system-ui" }],
      series: [{ label: "frequency", value: (_p, f) => (f === null ? "–" : `${f.toFixed(2)} Hz`) }, ...curves.map(([name]) => ({
        label: name, ...STYLES[name], points: { show: false }, spanGaps: true, value: (_p, v) => (v === null || v === undefined ? "–" : `${v.toFixed(1)} ${unit}`),
      }))],
    }, data, box);
    return { plot, height };
  }
}
