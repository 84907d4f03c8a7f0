// SPDX-License-Identifier: Apache-2.0
// The card of an axis: its state, and what moves it.

import { cancelPlan, confirmPlan } from "./plan.js";

const JOG_WORD_MS = 80;
// After this long the state shows a jog that runs.
const JOG_SHOWN_MS = 1000;
// Ten times the usual age of what is shown.
const STALE_S = 1;

export class AxisCard {
  constructor(axis, ask, connection) {
    this.axis = axis;
    this.name = ["azimuth", "pitch"][axis];
    this.ask = ask;
    this.connection = connection;
    this.jogging = null;
    const fragment = document.getElementById("axis").content.cloneNode(true);
    this.element = fragment.querySelector("article");
    this.element.dataset.axis = this.name;
    this.element.style.setProperty("--colour", `var(--${this.name})`);
    this.find("h2").textContent = this.name;
    this.find("legend").textContent = `Move ${this.name}`;
    this.element.setAttribute("aria-label", this.name);
    this.bind();
  }

  find(selector) {
    return this.element.querySelector(selector);
  }

  // NaN when the field holds no number: the server then says so.
  number(selector) {
    return this.find(selector).valueAsNumber;
  }

  bind() {
    const simple = (selector, what) => this.find(selector).addEventListener("click", () => this.ask(what, { axis: this.axis }));
    simple(".enable", "enable");
    simple(".disable", "disable");
    simple(".reset", "reset");
    simple(".hold", "hold");
    this.find(".move").addEventListener("click", () => this.move());
    this.find(".swing").addEventListener("click", () => this.plan(true, this.number(".move-angle"), "swing"));
    for (const [selector, sign] of [[".minus", -1], [".plus", 1]]) {
      const button = this.find(selector);
      button.setAttribute("aria-label", `Jog ${this.name} ${sign < 0 ? "back" : "forward"} while held`);
      button.addEventListener("pointerdown", (event) => {
        if (event.button !== 0) return;
        button.setPointerCapture(event.pointerId);
        this.jog(button, sign);
      });
      for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) button.addEventListener(end, () => this.release());
      button.addEventListener("keydown", (event) => {
        if ((event.key === " " || event.key === "Enter") && !event.repeat) this.jog(button, sign);
        if (event.key === " " || event.key === "Enter") event.preventDefault();
      });
      button.addEventListener("keyup", () => this.release());
      button.addEventListener("contextmenu", (event) => event.preventDefault());
    }
  }

  // --- motion ---------------------------------------------------------------------------------------------------------

  jog(button, sign) {
    if (this.jogging || button.disabled) return;
    cancelPlan(); // it was made for the place that the axis leaves
    this.jogging = button;
    this.spoken = this.begun = performance.now();
    button.classList.add("active");
    this.ask("jog", { axis: this.axis, rate_deg_s: sign * Math.abs(this.number(".jog-rate")) }).then((answer) => {
      if (answer === undefined) this.forget();
    });
  }

  // The button is still held.
  beat() {
    if (this.jogging && performance.now() - this.spoken >= JOG_WORD_MS) {
      this.spoken = performance.now();
      this.connection.send("held", { axis: this.axis });
    }
  }

  release() {
    if (!this.jogging) return;
    this.forget();
    this.ask("release_jog", { axis: this.axis });
  }

  forget() {
    this.jogging?.classList.remove("active");
    this.jogging = null;
  }

  move() {
    this.plan(this.find(".kind").value === "by", this.number(".move-angle"), "move");
  }

  // Shows what would move; only then it moves.
  async plan(relative, angle, what) {
    const rate = this.number(".move-rate");
    const plan = await this.ask("plan", { axis: this.axis, relative, angle_deg: angle, rate_deg_s: rate });
    if (!plan) return;
    const again = what === "swing" ? " and back, again and again until it is stopped" : "";
    if (await confirmPlan(plan, again, what === "swing" ? "until stopped" : undefined)) {
      this.ask(what, { axis: this.axis, angle_deg: what === "swing" ? angle : plan.target_deg, rate_deg_s: rate, from_deg: plan.from_deg });
    }
  }

  // --- state ----------------------------------------------------------------------------------------------------------

  show(axis, mayCommand, age) {
    this.element.classList.toggle("stale", age > STALE_S);
    const set = (selector, text) => {
      const element = this.find(selector);
      if (element.textContent !== text) element.textContent = text;
    };
    const faulty = axis.state === "fault" || axis.state === "fault reaction active";
    set(".state", axis.state);
    this.find(".state").className = `state chip ${faulty ? "bad" : axis.state === "operation enabled" ? "good" : ""}`;
    set(".angle", axis.position_deg === null ? "–" : axis.position_deg.toFixed(4));
    set(".rate", axis.rate_deg_s === null ? "–" : `${axis.rate_deg_s.toFixed(3)} °/s`);
    set(".torque", axis.torque_percent === null ? "–" : `${axis.torque_percent.toFixed(1)} % of rated`);
    set(".mode", axis.mode);
    const { low_deg: low, high_deg: high, rate_deg_s: fastest } = axis.limits;
    set(".limits", `${low === null ? "no end" : `${low.toFixed(0)}° … ${high.toFixed(0)}°`}, ${fastest.toFixed(0)} °/s`);
    set(".doing", axis.doing ? `${this.name} ${axis.doing}` : axis.held ? "holds" : axis.state === "operation enabled" ? "enabled by another master" : "");
    set(".age", age > STALE_S ? `· figures are ${age.toFixed(1)} s old` : "");
    this.find(".fault").hidden = !axis.fault;
    set(".fault strong", axis.fault);
    set(".cause", axis.cause ? `Cause: ${axis.cause}` : "");
    set(".cure", axis.cure ? `Remedy: ${axis.cure}` : "");
    this.find(".restriction").hidden = !axis.restriction;
    set(".restriction", axis.restriction);
    const allow = (selector, wanted) => { this.find(selector).disabled = !(mayCommand && wanted); };
    allow(".enable", !axis.held && !faulty);
    allow(".disable", axis.held || axis.state === "operation enabled");
    allow(".reset", faulty);
    allow(".hold", axis.held && axis.doing && !this.jogging);
    this.find(".reset").hidden = !faulty;
    this.find(".enable").hidden = faulty;
    const idle = axis.held && (!axis.doing || this.jogging);
    for (const selector of [".minus", ".plus", ".swing"]) allow(selector, idle);
    allow(".move", idle && !this.jogging);
    const ended = this.jogging && !axis.doing && performance.now() - this.begun > JOG_SHOWN_MS;
    if (!axis.held || ended) this.forget();
  }

  disable() {
    this.forget();
    for (const button of this.element.querySelectorAll("button")) button.disabled = true;
    const chip = this.find(".state");
    chip.textContent = "unknown";
    chip.className = "state chip";
    for (const selector of [".angle", ".rate", ".torque", ".mode"]) this.find(selector).textContent = "–";
    this.find(".doing").textContent = this.find(".age").textContent = "";
  }
}
