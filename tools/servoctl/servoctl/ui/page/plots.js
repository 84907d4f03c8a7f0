// SPDX-License-Identifier: Apache-2.0
// The plots of the live view: one for each kind of signal, over the same time.

import uPlot from "./uplot/uPlot.esm.js";
import { History } from "./history.js";

const HEIGHT = { angle: 200, rate: 200, torque: 190, "following error": 180 };
const PLACES = { "°": 4, "°/s": 4, "N m": 3, "µrad": 1 };

export const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export function format(value, unit) {
  return value === null || value === undefined ? "–" : `${value.toFixed(PLACES[unit] ?? 3)} ${unit}`;
}

// Texts of the powers of ten on a logarithmic axis; the ticks between them have none.
export function logTicks(ticks) {
  return ticks.map((tick) => (tick && Math.abs(Math.log10(tick) - Math.round(Math.log10(tick))) < 1e-6 ? String(+tick.toPrecision(3)) : ""));
}

export class Plots {
  constructor(place) {
    this.place = place;
    this.charts = [];
    this.history = null;
    this.frozen = null;
    this.live = null; // the live signals, behind a recording
    this.next = null; // other live signals, behind a paused picture
    this.window = 10;
    this.range = null;
    this.cursors = null;
    this.frames = 0;
    this.seen = 0;
    this.dirty = true;
    this.onZoom = () => {};
    this.onDraw = () => {};
    new ResizeObserver(() => this.resize()).observe(place);
    let rested = 0;
    const draw = (now) => {
      requestAnimationFrame(draw); // first: what goes wrong in one picture does not end the next ones
      if (this.dirty && !document.hidden && now >= rested) {
        this.draw();
        const end = performance.now();
        rested = end + end - now; // on a slow computer half of the time is left for the controls
      }
    };
    requestAnimationFrame(draw);
  }

  // Signals as the server describes them; other ones begin a new history, which waits behind what stands still.
  setSignals(signals, period) {
    const key = JSON.stringify([signals, period]);
    if (key === this.key) return;
    this.key = key;
    const found = { signals: withRoles(signals), history: new History(signals, period) };
    if (this.live) this.live = found;
    else if (this.frozen) this.next = found;
    else this.show(found);
  }

  // Live signals.
  show(found) {
    Object.assign(this, found, { live: null, next: null, frozen: null, range: null });
    this.build();
    this.onZoom(null);
  }

  // What comes live, also behind what stands still.
  get current() {
    return this.live ?? this.next ?? this;
  }

  // A recording takes the place of the live signals until `close`; these go on behind it.
  open(signals, history) {
    this.live ??= this.next ?? { signals: this.signals, history: this.history };
    this.next = null;
    Object.assign(this, { signals: withRoles(signals), history, frozen: history, range: [0, Math.max(history.end, 1e-3)] });
    this.build();
    this.onZoom(this.range);
  }

  close() {
    if (this.live) this.show(this.live);
  }

  add(buffer) {
    if (!this.history) return;
    this.seen += this.current.history.add(buffer);
    if (!this.frozen) this.dirty = true;
  }

  build() {
    for (const chart of this.charts) chart.plot.destroy();
    this.place.replaceChildren();
    const kinds = [...new Set(this.signals.map((signal) => signal.plot))];
    this.charts = kinds.map((kind, row) => this.chart(kind, row === kinds.length - 1));
    this.dirty = true;
  }

  chart(kind, last) {
    const chosen = this.signals.map((signal, n) => ({ ...signal, n })).filter((signal) => signal.plot === kind);
    const unit = chosen[0].unit;
    const box = document.createElement("div");
    box.className = "plot";
    box.setAttribute("role", "img");
    box.setAttribute("aria-label", `${kind} over time, ${unit}: ${chosen.map((signal) => signal.name).join(", ")}`);
    this.place.append(box);
    const axis = { stroke: () => css("--quiet"), grid: { stroke: () => css("--line"), width: 1 }, ticks: { show: false }, font: "12px system-ui" };
    const options = {
      width: this.place.clientWidth || 600,
      height: HEIGHT[kind] ?? 150,
      cursor: { sync: { key: "live" }, drag: { x: true, y: false, setScale: false }, points: { show: false } },
      legend: { live: true },
      padding: [22, 10, last ? 0 : 6, 0],
      scales: { x: { time: false, range: () => this.shown() }, y: { range: (_plot, low, high) => padded(low, high, unit) } },
      axes: [{ ...axis, show: last, size: 30, values: (_p, ticks) => ticks.map((t) => `${+t.toFixed(3)} s`) },
        { ...axis, size: 60, label: `${kind}  ${unit}`, labelSize: 18, labelFont: "12px system-ui" }],
      series: [{ label: "time", value: (_p, t) => (t === null ? "–" : `${t.toFixed(3)} s`) },
        ...chosen.map((signal) => ({
          label: signal.name, stroke: () => colour(signal), width: 1.4, spanGaps: false, points: { show: false },
          value: (_p, value) => format(value, unit),
        }))],
      hooks: {
        setSelect: [(plot) => this.zoom(plot)],
        draw: [(plot) => this.drawCursors(plot)],
      },
    };
    const plot = new uPlot(options, [[], ...chosen.map(() => [])], box);
    plot.over.addEventListener("dblclick", () => this.onZoom(null));
    return { plot, signals: chosen.map((signal) => signal.n), kind };
  }

  source() {
    return this.frozen ?? this.history;
  }

  shown() {
    if (this.range) return this.range;
    const end = this.source()?.end ?? 0;
    return [end - this.window, Math.max(end, 1e-3)];
  }

  draw() {
    this.dirty = false;
    const source = this.source();
    if (!source) return;
    const [from, to] = this.shown();
    for (const { plot, signals } of this.charts) {
      plot.setData(source.view(signals, from, to, Math.max(100, plot.bbox.width / devicePixelRatio)));
    }
    this.frames += 1;
    this.onDraw();
  }

  // A recording stands still anyway: it is shown as a whole again.
  pause(paused) {
    if (this.live) {
      this.range = [0, Math.max(this.history.end, 1e-3)];
      this.dirty = true;
      return;
    }
    if (this.next && !paused) {
      this.show(this.next);
      return;
    }
    if (!paused) this.frozen = this.range = null;
    else if (this.history) this.frozen ??= this.history.copy();
    this.dirty = true;
  }

  zoom(plot) {
    if (plot.select.width < 4) return;
    const from = plot.posToVal(plot.select.left, "x");
    const to = plot.posToVal(plot.select.left + plot.select.width, "x");
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    if (!this.frozen) this.pause(true);
    this.range = [from, to];
    this.dirty = true;
    this.onZoom(this.range);
  }

  // What is shown becomes `factor` times as long around its middle; beyond the window all is shown again.
  zoomBy(factor) {
    if (!this.history?.count) return;
    const [from, to] = this.shown();
    const middle = (from + to) / 2;
    const half = Math.max((factor * (to - from)) / 2, 2 * this.source().period);
    this.move([middle - half, middle + half]);
  }

  // By a share of what is shown; negative: earlier.
  shift(share) {
    const [from, to] = this.shown();
    this.move([from + share * (to - from), to + share * (to - from)]);
  }

  move([from, to]) {
    if (!this.history?.count) return;
    if (!this.frozen) this.pause(true);
    const { begin: first, end: last } = this.source();
    const length = Math.min(to - from, last - first);
    const begin = Math.min(Math.max(from, first), last - length);
    this.range = [begin, begin + length];
    this.dirty = true;
    this.onZoom(this.range);
  }

  setCursors(shares) {
    this.cursors = shares;
    this.dirty = true;
  }

  cursorTimes() {
    const [from, to] = this.shown();
    return this.cursors?.map((share) => from + share * (to - from));
  }

  drawCursors(plot) {
    const times = this.cursorTimes();
    if (!times) return;
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.strokeStyle = css("--ink");
    ctx.fillStyle = css("--ink");
    ctx.font = `${12 * devicePixelRatio}px system-ui`;
    times.forEach((time, n) => {
      const x = plot.valToPos(time, "x", true);
      ctx.setLineDash([4 * devicePixelRatio, 3 * devicePixelRatio]);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      ctx.fillText("AB"[n], x + 3 * devicePixelRatio, bbox.top + 12 * devicePixelRatio);
    });
    ctx.restore();
  }

  resize() {
    for (const { plot, kind } of this.charts) plot.setSize({ width: this.place.clientWidth, height: HEIGHT[kind] ?? 150 });
    this.dirty = true;
  }
}

// A second line of one axis in the same plot has a colour of its own.
function withRoles(signals) {
  const role = (signal) => (signal.name.includes("demanded") ? "demand" : signal.name.includes("joint") ? "joint" : "");
  const beside = (signal) => signals.some((other) => other.plot === signal.plot && other.axis === signal.axis && !role(other));
  return signals.map((signal) => ({ ...signal, role: beside(signal) ? role(signal) : "" }));
}

export function colour(signal) {
  if (signal.role) return css(`--${signal.role}`);
  return css(signal.axis === 0 ? "--azimuth" : "--pitch");
}

// A little room above and below; never less than what the sensors resolve.
function padded(low, high, unit) {
  if (low === null || high === null) return [-1, 1];
  const room = Math.max(0.08 * (high - low), unit === "µrad" ? 1 : 1e-3, 1e-6 * Math.abs(high));
  return [low - room, high + room];
}
