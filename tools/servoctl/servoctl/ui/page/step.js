// SPDX-License-Identifier: Apache-2.0
// The step response: the last one, and the one before it for comparison. Reference shapes are shown in the same plot.

import uPlot from "./uplot/uPlot.esm.js";
import { confirmPlan } from "./plan.js";

const $ = (id) => document.getElementById(id);
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const HEIGHT = 260;

export class Step {
  constructor(ask) {
    this.ask = ask;
    this.results = [];
    this.plot = null;
    $("step-go").addEventListener("click", () => this.measure());
    $("shape-go").addEventListener("click", () => this.run());
    $("step-axis").addEventListener("change", () => { this.results = []; this.shape = null; this.draw(); });
    new ResizeObserver(() => this.plot?.setSize({ width: $("step-plot").clientWidth, height: HEIGHT })).observe($("step-plot"));
  }

  enable(allowed) {
    $("step-go").disabled = $("shape-go").disabled = !allowed;
  }

  async measure() {
    const values = { axis: Number($("step-axis").value), amplitude_deg_s: $("step-amplitude").valueAsNumber, hold_s: $("step-hold").valueAsNumber };
    const plan = await this.ask("plan_step", values);
    if (!plan || !(await confirmPlan(plan))) return;
    $("step-note").textContent = "the step runs …";
    const result = await this.ask("step", values);
    $("step-note").textContent = result ? `measured; ${result.note || `${result.lost} samples lost`}` : "not measured";
    if (!result) return;
    this.results = [result, ...this.results].slice(0, 2);
    this.shape = null;
    this.draw();
  }

  async run() {
    const number = (name) => $(`shape-${name}`).valueAsNumber;
    const values = { axis: Number($("step-axis").value), shape: $("shape-kind").value, travel_deg: number("travel"), period_s: number("period"), periods: number("periods") };
    const plan = await this.ask("plan_shape", values);
    if (!plan || !(await confirmPlan(plan))) return;
    $("shape-note").textContent = "the axis moves …";
    const result = await this.ask("shape", values);
    $("shape-note").textContent = !result ? "not done"
      : `done; error of the rate ${result.rms_deg_s.toFixed(4)} °/s rms, ${result.largest_deg_s.toFixed(3)} °/s at most; ${result.lost} samples lost`;
    if (!result) return;
    this.shape = result;
    this.draw();
  }

  // Both directions of both measurements, over the time from the step.
  draw() {
    this.plot?.destroy();
    this.plot = null;
    const rows = [];
    const series = [];
    const data = [];
    this.results.forEach((result, age) => {
      for (const step of result.steps) {
        const name = `${step.direction}${age ? ", before" : ""}`;
        rows.push([name, step.half_ms, step.rise_ms, step.overshoot_percent, step.settling_ms, step.error_deg_s, step.noise_deg_s]);
        if (!age) {
          data.push([step.time_ms, step.demand_deg_s]);
          series.push({ label: `demand, ${step.direction}`, stroke: () => css("--demand"), width: 1 });
        }
        data.push([step.time_ms, step.rate_deg_s]);
        series.push({ label: name, stroke: () => css(age ? "--pitch" : "--azimuth"), width: age ? 1 : 1.6, dash: age ? [6, 4] : undefined });
      }
    });
    if (this.shape) {
      data.splice(0, data.length, [this.shape.time_ms, this.shape.demand_deg_s], [this.shape.time_ms, this.shape.rate_deg_s]);
      series.splice(0, series.length, { label: `demand, ${this.shape.shape}`, stroke: () => css("--demand"), width: 1 }, { label: "measured", stroke: () => css("--azimuth"), width: 1.6 });
    }
    const places = [1, 1, 1, 1, 5, 5];
    $("step-table").tBodies[0].replaceChildren(...rows.map(([name, ...values]) => {
      const row = document.createElement("tr");
      row.append(Object.assign(document.createElement("td"), { textContent: name }),
        ...values.map((value, n) => Object.assign(document.createElement("td"), { className: "number", textContent: value === null ? "–" : value.toFixed(places[n]) })));
      return row;
    }));
    if (!data.length) return;
    const axis = { stroke: () => css("--quiet"), grid: { stroke: () => css("--line"), width: 1 }, ticks: { show: false }, font: "12px system-ui" };
    this.plot = new uPlot({
      width: $("step-plot").clientWidth, height: HEIGHT, padding: [22, 10, 0, 0],
      scales: { x: { time: false } },
      axes: [{ ...axis, size: 30, values: (_p, ticks) => ticks.map((t) => `${t} ms`) }, { ...axis, size: 60, label: "rate  °/s", labelSize: 18, labelFont: "12px system-ui" }],
      series: [{ label: "time" }, ...series.map((each) => ({ ...each, points: { show: false }, spanGaps: true, value: (_p, v) => (v === null || v === undefined ? "–" : v.toFixed(3)) }))],
    }, uPlot.join(data), $("step-plot"));
  }
}
