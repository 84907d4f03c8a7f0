// SPDX-License-Identifier: Apache-2.0
// The WebSocket: requests with answers, states, events, and samples. It connects again by itself.

const RETRY_MS = 500;
const LOOK_MS = 250;
const SILENT_LOOKS = 8; // 2 s: states come ten times a second. In looks, because a busy page is late with both

export class Connection {
  constructor(handlers) {
    this.handlers = handlers;
    this.waiting = new Map();
    this.number = 0;
    this.stopWaits = false;
    this.looks = 0;
    setInterval(() => this.look(), LOOK_MS);
    this.open();
  }

  // A link that is cut, or a server that hangs, closes no socket.
  look() {
    this.looks += 1;
    if (this.looks >= SILENT_LOOKS && this.socket.readyState <= WebSocket.OPEN) this.lose(); // CONNECTING, too
  }

  lose() {
    const { socket } = this;
    socket.onmessage = socket.onclose = null;
    socket.close();
    for (const { reject } of this.waiting.values()) reject(new Error("the page has lost its server."));
    this.waiting.clear();
    this.handlers.lost();
    setTimeout(() => this.open(), RETRY_MS);
  }

  open() {
    this.looks = 0;
    this.socket = new WebSocket(`ws://${location.host}/ws`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => {
      this.looks = 0;
      this.sendStop();
    };
    this.socket.onmessage = (event) => this.take(event.data);
    this.socket.onclose = () => this.lose();
  }

  take(data) {
    this.looks = 0;
    if (data instanceof ArrayBuffer) {
      this.handlers.samples(data);
      return;
    }
    const message = JSON.parse(data);
    if (message.state) this.handlers.state(message.state);
    if (message.events) this.handlers.events(message.events);
    const waiting = this.waiting.get(message.reply);
    if (waiting) {
      this.waiting.delete(message.reply);
      if (message.error) waiting.reject(new Error(message.error));
      else waiting.resolve(message.result);
    }
  }

  // Without an answer.
  send(what, values = {}) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({ do: what, ...values }));
  }

  // Kept until the server has answered, and sent again when the connection is back.
  stop() {
    this.stopWaits = true;
    this.sendStop();
  }

  sendStop() {
    if (this.stopWaits) this.ask("stop").then(() => { this.stopWaits = false; }, () => {});
  }

  ask(what, values = {}) {
    return new Promise((resolve, reject) => {
      if (this.socket.readyState !== WebSocket.OPEN) {
        reject(new Error("the page has no connection to its server: is servoctl ui running?"));
        return;
      }
      this.number += 1;
      this.waiting.set(this.number, { resolve, reject });
      this.socket.send(JSON.stringify({ id: this.number, do: what, ...values }));
    });
  }
}
