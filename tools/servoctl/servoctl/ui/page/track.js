// SPDX-License-Identifier: Apache-2.0
// The tracking view: state and error of both image axes, the camera's frames and their delay; cue, follow and stop.

import { confirmPlan } from "./plan.js";

const $ = (id) => document.getElementById(id);
const AXES = ["azimuth", "pitch"];
const RMS_S = 1;
const ON_TARGET = ["acquiring", "tracking", "coasting"];

export class Track {
  constructor(ask, plots) {
    this.ask = ask;
    this.plots = plots;
    $("track-cue").addEventListener("click", () => this.cue());
    $("track-follow").addEventListener("click", () => this.follow());
    $("track-end").addEventListener("click", () => this.ask("end_follow"));
    $("track-plot").addEventListener("click", () => this.ask("choose", { choice: "tracking" }));
    this.rows = AXES.map((name) => {
      const row = $("track-table").tBodies[0].insertRow();
      row.append(Object.assign(document.createElement("th"), { textContent: name, scope: "row" }));
      return [0, 1, 2].map((n) => Object.assign(row.insertCell(), { className: n ? "number" : "track-state" }));
    });
  }

  show(state, mayCommand) {
    const { tracking, axes, stream } = state;
    $("tab-track").hidden = !tracking;
    if (!tracking) return;
    const held = axes.filter((axis) => axis.held);
    const idle = held.length > 0 && held.every((axis) => !axis.doing);
    $("track-cue").disabled = !(mayCommand && idle && held.length === AXES.length);
    $("track-follow").disabled = !(mayCommand && idle);
    $("track-end").disabled = !(mayCommand && tracking.follows);
    $("track-plot").disabled = !mayCommand || stream.choice === "tracking";
    const set = (element, text) => { if (element.textContent !== text) element.textContent = text; };
    AXES.forEach((name, axis) => {
      const [cell, now, rms] = this.rows[axis];
      const text = tracking.states[axis];
      set(cell, text);
      cell.dataset.state = text;
      const [last, spread] = ON_TARGET.includes(text) ? this.errors(`${name} following error`) : [null, null];
      set(now, last === null ? "–" : last.toFixed(1));
      set(rms, spread === null ? "–" : spread.toFixed(1));
    });
    const { taken, missed, dropped, age_ms: age } = tracking.frames;
    set($("track-frames"), `${taken} counted, ${missed} missed, ${dropped} dropped; newest ${age === 65535 ? "never" : `${age} ms old`}`);
    const delay = tracking.delay;
    set($("track-delay"), !delay ? "not measured by this firmware" : !delay.known ? "not known yet: both axes must track for some seconds"
      : `frames are ${delay.delay_ms.toFixed(2)} ± ${delay.half_interval_ms.toFixed(2)} ms older than stated; ${delay.added_ms} ms of it corrected`);
    set($("track-note"), tracking.note || (held.length ? "" : "enable the axes that shall follow"));
  }

  // The newest error and the rms of the last second, µrad; null while the live view shows other signals.
  errors(name) {
    const { history, signals } = this.plots.current;
    const n = signals?.findIndex((signal) => signal.name === name) ?? -1;
    if (n < 0 || !history?.count) return [null, null];
    const first = history.find(history.end - RMS_S);
    let sum = 0;
    for (let i = first; i < history.count; i++) sum += history.values[n][i] ** 2;
    return [history.values[n][history.count - 1], Math.sqrt(sum / (history.count - first))];
  }

  async cue() {
    const values = { azimuth_deg: $("track-azimuth").valueAsNumber, pitch_deg: $("track-pitch").valueAsNumber, rate_deg_s: $("track-rate").valueAsNumber,
      target_rate_deg_s: $("track-target-rate").value === "" ? null : Number($("track-target-rate").value) };
    const plans = await this.ask("plan_cue", values);
    if (!plans || !(await confirmPlan(plans))) return;
    const [azimuth, pitch] = plans;
    await this.ask("cue", { ...values, azimuth_from_deg: azimuth.from_deg, pitch_from_deg: pitch.from_deg });
  }

  async follow() {
    const camera = $("track-camera").value.trim();
    const axes = await this.ask("plan_follow");
    if (!axes) return;
    const text = axes.map(({ axis, here_deg: here, low_deg: low, high_deg: high, rate_deg_s: rate }) =>
      `${axis} from ${here.toFixed(2)}°, ${low === null ? "without an end of the travel" : `between ${low.toFixed(2)}° and ${high.toFixed(2)}°`}, at up to ${rate.toPrecision(4)} °/s`);
    if (!(await confirmPlan([], `The enabled axes will follow what the camera sees until they are stopped: ${text.join("; ")}.`))) return;
    await this.ask("choose", { choice: "tracking" });
    await this.ask("follow", { camera_id: camera, ...Object.fromEntries(axes.map(({ axis, here_deg: here }) => [`${axis}_from_deg`, here])) });
  }
}
