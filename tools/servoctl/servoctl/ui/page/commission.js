// SPDX-License-Identifier: Apache-2.0
// The guided commissioning: first look, identify, design, tune. What is in the folder of an identification says which step
// comes next, so each step can be left and taken up again, also from another page or after a restart of the server.

import uPlot from "./uplot/uPlot.esm.js";
import { css, logTicks } from "./plots.js";
import { confirmPlan } from "./plan.js";

const $ = (id) => document.getElementById(id);
const AXES = ["azimuth", "pitch"];
const STEPS = {
  look: { title: "first look", help: "A rough first look sizes the test plan. It assumes only the travel, the torque limit, and that the present gains keep the axis stable." },
  identify: { title: "identify", help: "The test plan measures friction and inertia, chirps find structural resonances, then the model is fitted. A part that is left begins again; finished parts stay. No gain changes." },
  design: { title: "design", help: "Gains are designed from the identification, beside the present ones. Nothing changes yet." },
  tune: { title: "tune", help: "The new gains are applied together and the loop is measured. They stay only if the margins are met; otherwise the old ones are restored." },
};
const REQUIREMENTS = [
  ["speed_loop_bandwidth_hz", "bandwidth of the speed loop", "Hz"], ["speed_loop_damping", "damping of the speed loop", ""],
  ["setpoint_weight", "set-point weight", ""], ["setpoint_model_hz", "frequency of the set-point model", "Hz"],
  ["observer_bandwidth_hz", "bandwidth of the observer", "Hz"],
  ["disturbance_rms_nm", "slow torque from outside, rms", "N m"], ["disturbance_corner_hz", "its corner frequency", "Hz"],
  ["least_gain_margin_db", "smallest gain margin", "dB"], ["least_phase_margin_deg", "smallest phase margin", "°"],
  ["most_torque_noise_nm", "largest torque noise", "N m"], ["tracking_bandwidth_hz", "bandwidth of the tracking loop", "Hz"],
  ["position_bandwidth_hz", "bandwidth of the position loop", "Hz"],
];
const DONE = { look: "first look", identify: "identify", design: "design", tune: "tune" };
const HEIGHT = 240;

const element = (tag, properties = {}, ...children) => {
  const found = Object.assign(document.createElement(tag), properties);
  found.append(...children);
  return found;
};

function table(caption, columns, rows) {
  const head = element("tr", {}, ...columns.map((text) => element("th", { textContent: text, scope: "col" })));
  const body = rows.map((cells) => element("tr", {}, ...cells.map((text) => element("td", { textContent: text }))));
  return element("div", { className: "scroll" }, element("table", {}, element("caption", { textContent: caption }), element("thead", {}, head), element("tbody", {}, ...body)));
}

// Undefined without the server: the page says so by itself.
const get = (path) => fetch(path).catch(() => undefined);

export class Commission {
  // `stop` leaves a step that moves; `changed` is called when gains may have changed.
  constructor(ask, stop, changed) {
    Object.assign(this, { ask, changed, step: "look", details: null, outcome: {}, plots: [], allowed: false, busy: false, begins: false });
    for (const button of document.querySelectorAll("[data-step]")) button.addEventListener("click", () => this.choose(button.dataset.step));
    $("co-axis").addEventListener("change", () => this.list());
    $("co-name").addEventListener("change", () => this.open($("co-name").value));
    $("co-dry").addEventListener("click", () => this.dryRun());
    $("co-go").addEventListener("click", () => this.go());
    $("co-leave").addEventListener("click", stop);
    $("co-unlock").addEventListener("change", () => { $("co-word-label").hidden = !$("co-unlock").checked; });
    $("co-requirements").append(...REQUIREMENTS.map(([name, text, unit]) =>
      element("label", {}, `${text} `, element("input", { type: "number", step: "any", min: "0", inputMode: "decimal", id: `co-${name}` }), ` ${unit}`)));
    new ResizeObserver(() => { for (const plot of this.plots) plot.setSize({ width: $("co-plot").clientWidth, height: HEIGHT }); }).observe($("co-plot"));
  }

  get axis() { return Number($("co-axis").value); }
  get name() { return $("co-name").value; }

  // --- what there is ----------------------------------------------------------------------------------------------------

  async list(name = this.name) {
    const answer = await get("commissioning");
    if (!answer?.ok) return;
    const mine = (await answer.json()).filter((each) => each.axis === AXES[this.axis]);
    $("co-name").replaceChildren(new Option("a new one", ""), ...mine.map((each) => new Option(`${each.name.slice(-16)}: ${each.done.at(-1) ?? "begun"}`, each.name)));
    await this.open(mine.some((each) => each.name === name) ? name : mine[0]?.name ?? "");
  }

  async open(name) {
    $("co-name").value = name;
    const answer = name ? await get(`commissioning/${name}`) : null;
    this.take(answer?.ok ? await answer.json() : null);
    if (answer && !answer.ok) $("co-note").textContent = await answer.text();
    this.choose(this.next());
  }

  take(details) {
    if (details?.name !== this.details?.name) this.outcome = {};
    this.details = details;
    $("co-limits").hidden = Boolean(details);
    $("co-envelope").textContent = details ? `${details.envelope} Files: ${details.folder}` : "Without angles and rate the limits of the node hold.";
  }

  has(step) { return this.details?.done.includes(DONE[step]) ?? false; }
  next() { return Object.keys(STEPS).find((step) => !this.has(step)) ?? "tune"; }

  // A step can begin when the one before it is done.
  canBegin(step) {
    const before = Object.keys(STEPS)[Object.keys(STEPS).indexOf(step) - 1];
    return !before || this.has(before) || (step === "tune" && this.has("identify"));
  }

  show(state, allowed) {
    this.allowed = allowed;
    this.busy = Boolean(state.busy);
    const running = state.commissioning;
    $("co-running").hidden = !running && !this.working;
    if (running) {
      $("co-progress").value = running.done_s / running.duration_s;
      const left = Math.max(0, running.duration_s - running.done_s);
      $("co-progress-text").textContent = `${running.axis}, ${running.part}: ${running.what}; about ${left.toFixed(0)} s left`;
    } else if (this.working) {
      $("co-progress").removeAttribute("value");
      $("co-progress-text").textContent = state.busy;
    }
    $("co-leave").disabled = !(running || (this.working && this.busy));
    this.enable();
  }

  enable() {
    $("co-go").disabled = !(this.allowed && !this.working && this.canBegin(this.step)) || (this.step === "look" && this.has("look")) || (this.step === "identify" && this.has("identify"));
    $("co-dry").disabled = this.working || this.busy || !this.canBegin(this.step) || this.has(this.step);
    $("co-axis").disabled = $("co-name").disabled = Boolean(this.working);
  }

  choose(step) {
    this.step = step;
    const moves = step === "look" || step === "identify";
    for (const button of document.querySelectorAll("[data-step]")) {
      const each = button.dataset.step;
      button.toggleAttribute("aria-current", false);
      if (each === step) button.setAttribute("aria-current", "step");
      button.dataset.done = this.has(each) ? "yes" : "no";
      button.querySelector("small").textContent = this.working === each ? "runs" : this.has(each) ? "done" : this.partly(each) ? "left, to be taken up" : this.canBegin(each) ? "next" : "later";
    }
    $("co-help").textContent = STEPS[step].help;
    $("co-design-form").hidden = step !== "design" && step !== "tune";
    $("co-tune-form").hidden = step !== "tune";
    $("co-unlock-label").hidden = step !== "tune";
    $("co-word-label").hidden = step !== "tune" || !$("co-unlock").checked;
    $("co-dry").hidden = !moves;
    $("co-go").textContent = step === "design" ? "Design" : this.partly(step) ? "Take up …" : step === "tune" ? "Try on the axis …" : "Start …";
    this.enable();
    this.draw();
  }

  partly(step) {
    const done = this.details?.done ?? [];
    return !this.has(step) && ((step === "identify" && done.includes("main test plan")) || (step === "look" && this.details !== null));
  }

  // --- what the buttons do ----------------------------------------------------------------------------------------------

  limits() {
    const value = (id) => ($(id).value === "" ? null : Number($(id).value));
    return { axis: this.axis, low_deg: value("co-low"), high_deg: value("co-high"), rate_deg_s: value("co-rate") };
  }

  async dryRun(limits = this.limits(), name = this.name, step = this.step) {
    $("co-note").textContent = "";
    const found = await this.ask("dry_run", { ...limits, name, step });
    if (found) this.showPlan(found, "dry run: nothing was moved");
    return found;
  }

  showPlan(found, note) {
    $("co-note").textContent = note;
    $("co-result").replaceChildren(element("p", { textContent: found.envelope }),
      ...found.plans.flatMap((plan) => [table(plan.title, found.columns, plan.rows), element("p", { className: "quiet", textContent: plan.summary })]));
  }

  requirements() {
    return Object.fromEntries(REQUIREMENTS.map(([name]) => [name, $(`co-${name}`).value]).filter(([, text]) => text !== "").map(([name, text]) => [name, Number(text)]));
  }

  async go() {
    await ({ look: () => this.measure(), identify: () => this.measure(), design: () => this.design(), tune: () => this.tune() }[this.step])();
  }

  async measure() {
    const [step, limits, taken] = [this.step, this.limits(), this.name]; // those that are shown are those that move
    const found = await this.dryRun(limits, taken, step);
    if (!found) return;
    $("co-note").textContent = "";
    const seconds = found.plans.reduce((sum, plan) => sum + plan.duration_s, 0);
    if (!(await confirmPlan([], `${found.envelope} ${found.plans.map((plan) => `${plan.title}: ${plan.summary}`).join(" ")} About ${seconds.toFixed(0)} s in all.`))) return;
    const name = taken || (await this.ask("begin", limits));
    if (!name) return;
    $("co-axis").value = limits.axis;
    await this.list(name);
    await this.work(step, { name });
  }

  async design() {
    await this.work("design", { name: this.name, requirements: this.requirements() });
  }

  async tune() {
    const number = (id) => $(id).valueAsNumber;
    const wanted = { requirements: this.requirements(), unlock: $("co-unlock").checked, word: $("co-word").value };
    const values = { name: this.name, bias_deg_s: number("co-bias"), amplitude_deg_s: number("co-amplitude"), high_hz: number("co-top"), periods: number("co-periods") };
    const plan = await this.ask("plan_tune", values);
    if (!plan || !(await confirmPlan(plan, ". Gains change meanwhile."))) return;
    await this.work("tune", { ...values, ...wanted });
  }

  // A step on the server; on a refusal or a stop what was finished before it stays.
  async work(step, values) {
    this.working = step;
    this.choose(step);
    $("co-note").textContent = "";
    const found = await this.ask(step, values);
    this.working = null;
    if (found) {
      this.outcome[step] = found;
      this.take(found.details ?? found);
      if (step === "tune") this.changed();
    }
    await this.list(values.name);
    this.choose(step);
    $("co-note").textContent = found ? found.text ?? `${STEPS[step].title}: done` : `${STEPS[step].title}: left; it can be taken up again`;
  }

  // --- what the steps have found ------------------------------------------------------------------------------------------

  draw() {
    for (const plot of this.plots) plot.destroy();
    $("co-plot").replaceChildren();
    this.plots = [];
    const { details, step } = this;
    const parts = [];
    if (details && (step === "look" || step === "identify") && this.has(step)) parts.push(...this.identified(details));
    if (step === "design" || step === "tune") parts.push(...this.designed());
    $("co-result").replaceChildren(...parts);
    $("co-files").replaceChildren(...(details ? details.files.flatMap((file) => [element("a", { href: `commissioning/${details.name}/${file}`, target: "_blank", rel: "noopener", textContent: file }), " "]) : []));
  }

  identified({ identified, friction }) {
    if (friction) {
      const curves = friction.curves.flatMap((each) => [
        { label: `measured, ${each.direction}`, x: each.speed_deg_s, y: each.torque_nm, points: true, colour: each.direction === "positive" ? "--azimuth" : "--pitch" },
        ...(each.model_nm ? [{ label: `model, ${each.direction}`, x: each.model_speed_deg_s, y: each.model_nm, colour: each.direction === "positive" ? "--azimuth" : "--pitch" }] : []),
      ]);
      this.plot("friction torque over joint speed", "N m", "°/s", curves);
    }
    if (!identified) return [];
    return [
      ...identified.refused.map((text) => element("p", { className: "notice", textContent: `Not determined: ${text}` })),
      ...identified.warnings.map((text) => element("p", { className: "notice", textContent: text })),
      table(this.step === "look" ? "Rough values of the first look" : "Identified", ["parameter", "value", "95 % interval, %", "paper's method", "unit"], identified.rows),
    ];
  }

  designed() {
    const tuned = this.step === "tune" ? this.outcome.tune : null;
    const found = tuned ?? this.outcome.design;
    const loop = found?.loop ?? this.details?.design?.loop;
    if (loop) {
      const curves = [["predicted by the design", loop, "--demand"], ["before: measured plant, old gains", tuned?.before, "--pitch"], ["measured with the new gains", tuned?.measured, "--azimuth"]]
        .filter(([, curve]) => curve);
      this.plot("open loop gain", "dB", "Hz", curves.map(([label, curve, colour]) => ({ label, x: curve.frequency_hz, y: curve.db, colour })));
      this.plot("open loop phase", "°", "Hz", curves.map(([label, curve, colour]) => ({ label, x: curve.frequency_hz, y: curve.deg, colour })));
    }
    if (!found) return loop ? [element("p", { className: "quiet", textContent: "Design again to compare with the present gains." })] : [];
    const margin = (value) => (value === null ? "–" : value.toFixed(1));
    return [
      ...(tuned ? [element("p", { className: "notice", textContent: tuned.text }),
        table("Margins", ["margin", "unit", "required", "predicted", "measured", "met"], tuned.verdicts.map((v) => [v.name, v.unit, margin(v.wished ? v.required : null), margin(v.predicted), margin(v.measured), v.kept ? "yes" : "no"]))] : []),
      table(found.rows.length ? "Gains" : "The device has these gains already", ["gain", "before", "after", "unit"], found.rows.map((row) => [`${row.name}${row.guarded ? " (guarded)" : ""}`, row.before, row.after, row.unit])),
      element("p", { textContent: `Predicted: ${found.predicted}` }),
      ...found.notes.map((text) => element("p", { className: "quiet", textContent: text })),
      ...(found.left_out.length ? [element("p", { className: "notice", textContent: "The identified plant (2056), against which the device checks gains, is guarded and stays as it is; with Unlock it is written too." })] : []),
    ];
  }

  plot(kind, unit, over, curves) {
    const box = element("div", { className: "plot" });
    box.setAttribute("role", "img");
    box.setAttribute("aria-label", `${kind}, ${unit}: ${curves.map((curve) => curve.label).join(", ")}`);
    $("co-plot").append(box);
    const axis = { stroke: () => css("--quiet"), grid: { stroke: () => css("--line"), width: 1 }, ticks: { show: false }, font: "12px system-ui" };
    const data = uPlot.join(curves.map(({ x, y }) => {
      const order = x.map((_, n) => n).sort((a, b) => x[a] - x[b]);
      return [order.map((n) => x[n]), order.map((n) => y[n])];
    }));
    this.plots.push(new uPlot({
      width: $("co-plot").clientWidth || 600, height: HEIGHT, padding: [22, 10, 0, 0], scales: { x: { time: false, distr: 3 } },
      axes: [{ ...axis, size: 30, values: (_p, ticks) => logTicks(ticks).map((text) => (text ? `${text} ${over}` : "")) }, { ...axis, size: 60, label: `${kind}  ${unit}`, labelSize: 18, labelFont: "12px system-ui" }],
      series: [{ label: over, value: (_p, x) => (x === null ? "–" : `${x.toPrecision(3)} ${over}`) }, ...curves.map(({ label, colour, points }) => ({
        label, stroke: () => css(colour), width: points ? 0 : 1.6, paths: points ? () => null : undefined, points: { show: Boolean(points), size: 6, fill: () => css(colour) },
        spanGaps: true, value: (_p, v) => (v === null || v === undefined ? "–" : `${v.toPrecision(4)} ${unit}`),
      }))],
    }, data, box));
  }
}
