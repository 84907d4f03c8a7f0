// SPDX-License-Identifier: Apache-2.0
// The amplitude spectrum of what the live view shows.

import uPlot from "./uplot/uPlot.esm.js";
import { colour, css, logTicks } from "./plots.js";

const $ = (id) => document.getElementById(id);
const HEIGHT = 240;
const EVERY_MS = 400;
const FEWEST = 64;
const LONGEST = 1 << 15;

// Of a real signal with a power of two samples: amplitudes (peak) of the lines from 0 to half of the sample rate. Hann
// window, without the mean.
export function amplitudes(values) {
  const n = values.length;
  const mean = values.reduce((sum, value) => sum + value, 0) / n;
  const re = new Float64Array(n);
  const im = new Float64Array(n);
  for (let i = 0; i < n; i++) re[i] = (values[i] - mean) * (1 - Math.cos((2 * Math.PI * i) / n)); // its mean is 1
  transform(re, im);
  return Float64Array.from({ length: n / 2 }, (_, k) => (2 * Math.hypot(re[k], im[k])) / n);
}

// In place, radix 2.
function transform(re, im) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; i++) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) {
      [re[i], re[j]] = [re[j], re[i]];
      [im[i], im[j]] = [im[j], im[i]];
    }
  }
  for (let size = 2; size <= n; size *= 2) {
    const turn = (-2 * Math.PI) / size;
    for (let k = 0; k < size / 2; k++) {
      const c = Math.cos(turn * k);
      const s = Math.sin(turn * k);
      for (let i = k; i < n; i += size) {
        const j = i + size / 2;
        const x = re[j] * c - im[j] * s;
        const y = re[j] * s + im[j] * c;
        re[j] = re[i] - x;
        im[j] = im[i] - y;
        re[i] += x;
        im[i] += y;
      }
    }
  }
}

// The newest stretch of the shown time without a gap, cut to a power of two: index of its first sample, and its length.
export function stretch(source, from, to) {
  const last = Math.min(source.count, source.find(to) + 1);
  const begin = source.find(from);
  let first = last;
  while (first > begin && (first === last || source.time[first] - source.time[first - 1] < 1.5 * source.period)) first -= 1;
  const length = Math.min(LONGEST, 2 ** Math.floor(Math.log2(Math.max(1, last - first))));
  return [last - length, length];
}

export class Spectrum {
  constructor(plots) {
    this.plots = plots;
    this.plot = null;
    this.drawn = 0;
    $("spectrum").addEventListener("click", () => this.toggle());
    $("spectrum-kind").addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.plot?.setSize({ width: $("spectrum-plot").clientWidth, height: HEIGHT })).observe($("spectrum-plot"));
  }

  toggle() {
    $("spectrum-panel").hidden = !$("spectrum-panel").hidden;
    $("spectrum").setAttribute("aria-pressed", String(!$("spectrum-panel").hidden));
    this.draw();
  }

  // Call after each drawing of the live view.
  refresh() {
    if (!$("spectrum-panel").hidden && performance.now() - this.drawn > EVERY_MS) this.draw();
  }

  draw() {
    this.drawn = performance.now();
    const source = this.plots.source();
    if ($("spectrum-panel").hidden || !source) return;
    this.showKinds();
    const chosen = this.plots.signals.map((signal, n) => ({ ...signal, n })).filter((signal) => signal.plot === $("spectrum-kind").value);
    const [first, length] = stretch(source, ...this.plots.shown());
    if (length < FEWEST) {
      $("spectrum-note").textContent = `needs at least ${FEWEST} samples without a gap`;
      return;
    }
    const spectra = chosen.map((signal) => amplitudes(source.values[signal.n].subarray(first, first + length)));
    const step = 1 / (length * source.period);
    const data = [Array.from({ length: length / 2 - 1 }, (_, k) => (k + 1) * step), ...spectra.map((each) => Array.from(each.subarray(1), (value) => value || null))];
    $("spectrum-note").textContent = `${(length * source.period).toPrecision(3)} s, Hann window, lines every ${step.toPrecision(3)} Hz; largest: ${chosen.map((signal, i) => peak(signal, data, i + 1)).join(", ")}`;
    this.show(chosen, data);
  }

  showKinds() {
    const kinds = [...new Set(this.plots.signals.map((signal) => signal.plot))];
    const select = $("spectrum-kind");
    if (kinds.join() === [...select.options].map((option) => option.value).join()) return;
    const before = select.value;
    select.replaceChildren(...kinds.map((kind) => new Option(kind, kind)));
    select.value = kinds.includes(before) ? before : kinds.includes("rate") ? "rate" : kinds[0];
  }

  show(chosen, data) {
    const key = JSON.stringify([chosen, document.documentElement.dataset.theme]);
    if (this.key === key) {
      this.plot.setData(data);
      return;
    }
    this.key = key;
    this.plot?.destroy();
    const axis = { stroke: () => css("--quiet"), grid: { stroke: () => css("--line"), width: 1 }, ticks: { show: false }, font: "12px system-ui" };
    this.plot = new uPlot({
      width: $("spectrum-plot").clientWidth, height: HEIGHT, padding: [22, 10, 0, 0],
      scales: { x: { time: false, distr: 3, range: (_plot, low, high) => [low, high] }, y: { distr: 3 } },
      axes: [{ ...axis, size: 30, values: (_p, ticks) => logTicks(ticks).map((text) => (text ? `${text} Hz` : "")) },
        { ...axis, size: 70, values: (_p, ticks) => logTicks(ticks), label: `amplitude  ${chosen[0].unit}`, labelSize: 18, labelFont: "12px system-ui" }],
      series: [{ label: "frequency", value: (_p, f) => (f === null ? "–" : `${f.toFixed(2)} Hz`) }, ...chosen.map((signal) => ({
        label: signal.name, stroke: () => colour(signal), width: 1.2, points: { show: false }, value: (_p, v) => (v === null || v === undefined ? "–" : `${v.toPrecision(3)} ${signal.unit}`),
      }))],
    }, data, $("spectrum-plot"));
  }
}

function peak(signal, data, column) {
  let at = 0;
  data[column].forEach((value, k) => { if (value > data[column][at]) at = k; });
  return `${signal.name} ${(data[column][at] ?? 0).toPrecision(3)} ${signal.unit} at ${data[0][at].toPrecision(3)} Hz`;
}
