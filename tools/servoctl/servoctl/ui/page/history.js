// SPDX-License-Identifier: Apache-2.0
// The last 60 s of all signals, and what of it a plot of some width can show.

const SECONDS = 60;
const TICK_S = 0.001;
const WRAP = 2 ** 32;

export class History {
  // `count`: room for so many samples, all of which are kept; otherwise for the last SECONDS.
  constructor(signals, periodTicks, count = undefined) {
    this.period = periodTicks * TICK_S;
    this.capacity = count ?? Math.round(SECONDS / this.period);
    const room = count ?? 2 * this.capacity;
    this.time = new Float64Array(room);
    this.values = signals.map(() => new Float32Array(room));
    this.count = 0;
    this.lastTick = null;
    this.lastTime = 0;
  }

  // A message of samples: number of samples and signals, ticks, values of each signal. Returns how many it has.
  add(buffer) {
    const [samples, signals] = new Uint32Array(buffer, 0, 2);
    if (signals !== this.values.length) return 0;
    if (this.count + samples > this.time.length) this.drop();
    const ticks = new Uint32Array(buffer, 8, samples);
    for (let i = 0; i < samples; i++) this.time[this.count + i] = this.timeOf(ticks[i]);
    for (let s = 0; s < signals; s++) {
      this.values[s].set(new Float32Array(buffer, 8 + 4 * samples * (1 + s), samples), this.count);
    }
    this.count += samples;
    return samples;
  }

  // Grows from 0 with the ticks of the node; a node that has started again continues after a second without samples.
  timeOf(tick) {
    if (this.lastTick !== null) {
      const passed = (tick - this.lastTick + WRAP) % WRAP;
      this.lastTime += passed < WRAP / 2 ? passed * TICK_S : 1;
    }
    this.lastTick = tick;
    return this.lastTime;
  }

  // The older half makes room.
  drop() {
    const from = this.count - this.capacity;
    this.time.copyWithin(0, from, this.count);
    for (const values of this.values) values.copyWithin(0, from, this.count);
    this.count = this.capacity;
  }

  get end() {
    return this.count ? this.time[this.count - 1] : 0;
  }

  get begin() {
    return this.count ? this.time[Math.max(0, this.count - this.capacity)] : 0;
  }

  copy() {
    const copy = Object.create(History.prototype);
    Object.assign(copy, this, { time: this.time.slice(0, this.count), values: this.values.map((v) => v.slice(0, this.count)) });
    return copy;
  }

  // Index of the first sample at or after a time.
  find(time) {
    let low = 0;
    let high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  at(signal, time) {
    const found = this.find(time);
    if (found >= this.count || Math.abs(this.time[found] - time) > 2 * this.period) return null;
    return this.values[signal][found];
  }

  // Some signals between two times, at most two points per pixel: the smallest and the largest value in each. Missing
  // samples become a gap.
  view(signals, from, to, pixels) {
    const first = Math.max(0, this.find(from) - 1);
    const last = Math.min(this.count, this.find(to) + 1);
    const step = Math.max(1, Math.ceil((last - first) / (2 * pixels)) * 2);
    const time = [];
    const columns = signals.map(() => []);
    const apart = 1.5 * this.period;
    let i = first;
    while (i < last) {
      let end = i + 1;
      while (end < last && end < i + step && this.time[end] - this.time[end - 1] < apart) end += 1;
      const pair = end - i > 2;
      time.push(this.time[i]);
      if (pair) time.push(this.time[end - 1]);
      signals.forEach((signal, c) => {
        const values = this.values[signal];
        if (!pair) {
          columns[c].push(values[i]);
          return;
        }
        let low = i;
        let high = i;
        for (let k = i + 1; k < end; k++) {
          if (values[k] < values[low]) low = k;
          if (values[k] > values[high]) high = k;
        }
        columns[c].push(values[Math.min(low, high)], values[Math.max(low, high)]);
      });
      if (!pair && end - i === 2) {
        end = i + 1;
      }
      if (end < last && this.time[end] - this.time[end - 1] >= apart) {
        time.push(this.time[end - 1] + this.period);
        for (const column of columns) column.push(null);
      }
      i = end;
    }
    return [time, ...columns];
  }
}
