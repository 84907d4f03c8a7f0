// SPDX-License-Identifier: Apache-2.0
// The page: brings connection, plots, axes, gains and faults together.

import { Connection } from "./connection.js";
import { Plots, format } from "./plots.js";
import { AxisCard } from "./axis.js";
import { Gains } from "./gains.js";
import { Commission } from "./commission.js";
import { Bode } from "./bode.js";
import { GainFile } from "./gain_file.js";
import { Spectrum } from "./spectrum.js";
import { Recordings } from "./recordings.js";
import { Scope } from "./scope.js";
import { Step } from "./step.js";
import { Track } from "./track.js";
import { cancelPlan } from "./plan.js";
import { showFaults } from "./faults.js";

const $ = (id) => document.getElementById(id);
let state = null;
let mine = false;
let connected = false;
// When the connection was lost.
let commanded = false;

// --- messages to the reader -------------------------------------------------------------------------------------------

let toastTimer = 0;
function complain(error) {
  $("toast").textContent = error.message ?? String(error);
  clearTimeout(toastTimer);
  toastTimer = setTimeout(() => { $("toast").textContent = ""; }, 9000);
  addEvents([{ kind: "bad", time: Date.now() / 1000, text: $("toast").textContent }]);
}

function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

// Bad ones that nobody has seen yet, beside the name of their tab.
let unread = 0;
function markUnread(count) {
  unread = count;
  setText($("tab-events"), unread ? `Events (${unread} new)` : "Events");
  $("tab-events").classList.toggle("bad", unread > 0);
}

let newest = { run: 0, number: 0 };
// After a lost link the server sends those of before, too; another server counts anew.
const addNew = (events) => {
  addEvents(events.filter(({ run, number }) => run !== newest.run || number > newest.number));
  newest = events.at(-1) ?? newest;
};

function addEvents(events) {
  if ($("panel-events").hidden) markUnread(unread + events.filter((event) => event.kind === "bad").length);
  for (const event of events) {
    const item = document.createElement("li");
    item.className = event.kind;
    const time = document.createElement("time");
    time.textContent = new Date(1000 * event.time).toLocaleTimeString();
    item.append(time, event.text);
    $("events").prepend(item);
  }
  while ($("events").children.length > 200) $("events").lastChild.remove();
}

// --- connection -------------------------------------------------------------------------------------------------------

const plots = new Plots($("plots"));
const connection = new Connection({
  samples: (buffer) => plots.add(buffer),
  state: (received) => show(received),
  events: addNew,
  lost: () => {
    commanded = commanded || mine;
    mine = false;
    connected = false;
    sayLost();
    for (const card of cards) card.disable();
    setText($("link"), "no server");
    $("link").className = "chip bad";
    for (const id of ["load", "rate", "lost"]) setText($(id), "–");
    setText($("who"), "");
  },
});

function sayLost() {
  const axes = commanded ? "This page commanded, so the axes stop meanwhile." : "This page only viewed: the axes may go on.";
  const waits = connection.stopWaits ? " STOP could not be sent: it is sent as soon as the connection is back." : "";
  $("trouble").hidden = false;
  setText($("trouble"), `The page has lost its server: is 'servoctl ui' running? It connects again by itself. ${axes}${waits}`);
}

async function ask(what, values) {
  try {
    return await connection.ask(what, values);
  } catch (error) {
    complain(error);
    return undefined;
  }
}

const cards = [0, 1].map((axis) => new AxisCard(axis, ask, connection));
document.querySelector(".axes").append(...cards.map((card) => card.element));
const gains = new Gains(ask);
const bode = new Bode(ask);
gains.onChange = () => bode.predict();
const gainFile = new GainFile(ask, gains);
const spectrum = new Spectrum(plots);
const step = new Step(ask);
const recordings = new Recordings(ask, plots, complain);
const scope = new Scope(ask);
const commission = new Commission(ask, () => stop(), () => gains.read(""));
const track = new Track(ask, plots);

new Worker("beat.js").onmessage = () => {
  if (mine) connection.send("beat");
  for (const card of cards) card.beat();
};

function show(received) {
  state = received;
  const { link, node, stream, pages } = received;
  mine = pages.commander === pages.you;
  connected = true;
  commanded = false;
  setText($("node-name"), node.node ? `${node.name ?? ""} · node ${node.node} · ${node.firmware ?? node.software ?? ""}` : "");
  setText($("link"), link.up ? (node.nmt ?? "connected") : "no connection");
  $("link").className = `chip ${link.up ? (node.nmt === "operational" ? "good" : "") : "bad"}`;
  $("link").title = link.text;
  $("start-node").hidden = link.up ? node.nmt !== "pre-operational" : !link.stopped;
  $("start-node").disabled = !mine;
  const trouble = !link.up ? link.text : node.mismatch || "";
  $("trouble").hidden = !trouble;
  setText($("trouble"), trouble);
  setText($("load"), !link.up ? "–" : received.load === null ? "unknown" : `${(100 * received.load).toFixed(0)} %`);
  $("load").title = received.load === null ? "neither the node nor the interface reports the bit rate" : "of the frames received";
  setText($("rate"), stream.period_ms && node.nmt === "operational" ? `${1000 / stream.period_ms} Hz` : "–");
  setText($("lost"), stream.period_ms ? String(stream.missing + pages.dropped) : "–");
  $("lost").title = `${stream.missing} on the bus, ${pages.dropped} on the way to this page; a lost link is a gap, and is not counted`;
  const others = pages.viewers.length - 1;
  setText($("who"), `${mine ? "this page commands" : pages.text}${others ? ` · ${others} other page${others > 1 ? "s" : ""}` : ""}`);
  setText($("command"), mine ? "Release command" : "Take command");
  $("command").className = mine ? "" : "primary";
  if (stream.signals.length) plots.setSignals(stream.signals, stream.period_ms);
  setText($("stream-note"), stream.note ?? "");
  showChoices(stream);
  for (const axis of received.axes) {
    cards.find((card) => card.name === axis.axis)?.show(axis, mine && link.up && !received.busy, received.axes_age_s);
  }
  if (!link.up) for (const card of cards) card.disable();
  gains.enable(mine && link.up);
  gainFile.enable(mine && link.up, !received.busy && received.axes.every((axis) => !axis.held && axis.state !== "operation enabled"));
  const measures = mine && link.up && !received.busy && received.axes.every((axis) => !axis.held && !axis.fault);
  step.enable(measures);
  bode.enable(measures);
  commission.show(received, measures);
  recordings.show(received, mine && link.up);
  scope.show(received, mine && link.up && !received.busy);
  track.show(received, mine && link.up && !received.busy);
  const silent = link.up && !$("start-node").hidden ? "the node sends no samples until it is started" : "";
  setText($("busy"), received.busy || silent);
  if (!link.up) {
    gains.asked = false; // another client or another node may have changed them when it is back
    cancelPlan();
  }
  if (link.up && !gains.asked) gains.read();
  else if (link.up) gains.follow(received.sets);
  $("choice").disabled = !mine;
}

function showChoices(stream) {
  const texts = { both: "both axes", tracking: "both axes: error, demand", azimuth: "azimuth: demand, error", pitch: "pitch: demand, error" };
  if (!$("choice").options.length) {
    for (const choice of stream.choices) $("choice").add(new Option(texts[choice] ?? choice, choice));
  }
  if (document.activeElement !== $("choice")) $("choice").value = stream.choice;
}

// A browser drops the comma of "12,5" from a field for numbers, and 125 is left.
addEventListener("beforeinput", (event) => {
  if (event.target.type !== "number" || !event.data?.includes(",")) return;
  event.preventDefault();
  complain(new Error("write decimals with a point, as in 12.5."));
}, true);

// --- head -------------------------------------------------------------------------------------------------------------

function stop() {
  cancelPlan();
  for (const card of cards) card.forget();
  connection.stop();
  if (!connected) sayLost();
}

$("stop").addEventListener("click", stop);
addEventListener("keydown", (event) => {
  if (event.key === "Escape") stop();
}, true);
$("command").addEventListener("click", () => ask(mine ? "release" : "take"));
$("start-node").addEventListener("click", () => ask("start_node"));
$("choice").addEventListener("change", () => ask("choose", { choice: $("choice").value }));
document.addEventListener("visibilitychange", () => {
  if (document.hidden) for (const card of cards) card.release();
});
addEventListener("pagehide", () => {
  if (mine) connection.send("stop");
  connection.socket.close();
});
addEventListener("blur", () => { for (const card of cards) card.release(); });

const dark = matchMedia("(prefers-color-scheme: dark)");
function setTheme() {
  const chosen = localStorage.getItem("theme");
  document.documentElement.dataset.theme = chosen ?? (dark.matches ? "dark" : "light");
  plots.build?.call(plots.signals ? plots : { charts: [], place: document.createElement("div"), signals: [] });
}
dark.addEventListener("change", setTheme);
$("theme").addEventListener("click", () => {
  localStorage.setItem("theme", document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  setTheme();
});
setTheme();

// --- live view --------------------------------------------------------------------------------------------------------

function showWindow() {
  for (const button of document.querySelectorAll("[data-window]")) {
    button.setAttribute("aria-pressed", String(!plots.range && Number(button.dataset.window) === plots.window));
  }
  $("pause").setAttribute("aria-pressed", String(Boolean(plots.frozen)));
  setText($("pause"), plots.frozen ? "Go on" : "Pause");
  $("pause").disabled = Boolean(plots.live);
  const width = plots.range ? plots.range[1] - plots.range[0] : 0;
  setText($("zoom-note"), plots.range ? `${width.toPrecision(3)} s shown; double-click or Home to go back` : "drag to zoom");
}

for (const button of document.querySelectorAll("[data-window]")) {
  button.addEventListener("click", () => {
    plots.window = Number(button.dataset.window);
    plots.range = null;
    plots.dirty = true;
    showWindow();
  });
}
plots.onZoom = (range) => {
  if (!range) plots.pause(false);
  showWindow();
};
const ZOOM = 2;
const SHIFT = 0.25;
const views = {
  "zoom-in": () => plots.zoomBy(1 / ZOOM), "zoom-out": () => plots.zoomBy(ZOOM),
  "zoom-back": () => plots.shift(-SHIFT), "zoom-on": () => plots.shift(SHIFT),
};
const keys = { "+": "zoom-in", "=": "zoom-in", "-": "zoom-out", ArrowLeft: "zoom-back", ArrowRight: "zoom-on" };
for (const [id, change] of Object.entries(views)) $(id).addEventListener("click", change);
$("plots").addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "Home") plots.onZoom(null);
  else if (keys[event.key]) views[keys[event.key]]();
  else return;
  event.preventDefault();
});
$("pause").addEventListener("click", () => {
  plots.pause(!plots.frozen);
  showWindow();
});
$("cursors").addEventListener("click", () => {
  const on = $("cursor-panel").hidden;
  $("cursor-panel").hidden = !on;
  $("cursors").setAttribute("aria-pressed", String(on));
  moveCursors();
});
function moveCursors() {
  plots.setCursors($("cursor-panel").hidden ? null : [Number($("cursor-a").value), Number($("cursor-b").value)]);
}
for (const id of ["cursor-a", "cursor-b"]) $(id).addEventListener("input", moveCursors);

let cursorsShown = 0;
plots.onDraw = () => {
  spectrum.refresh();
  const times = plots.cursorTimes();
  if (!times || performance.now() - cursorsShown < 100) return;
  cursorsShown = performance.now();
  const source = plots.source();
  const rows = [["time", ...times.map((t) => `${t.toFixed(3)} s`), `${(times[1] - times[0]).toFixed(3)} s`]];
  plots.signals.forEach((signal, n) => {
    const [a, b] = times.map((time) => source.at(n, time));
    rows.push([signal.name, format(a, signal.unit), format(b, signal.unit), a === null || b === null ? "–" : format(b - a, signal.unit)]);
  });
  $("cursor-table").tBodies[0].replaceChildren(...rows.map((cells) => {
    const row = document.createElement("tr");
    row.append(...cells.map((text) => Object.assign(document.createElement("td"), { textContent: text })));
    return row;
  }));
};

// --- tabs -------------------------------------------------------------------------------------------------------------

const tabs = [...document.querySelectorAll("[role=tab]")];
function choose(tab) {
  for (const each of tabs) {
    each.setAttribute("aria-selected", String(each === tab));
    each.tabIndex = each === tab ? 0 : -1;
    $(each.getAttribute("aria-controls")).hidden = each !== tab;
  }
  if (tab.id === "tab-events") markUnread(0);
  if (tab.id === "tab-faults") readFaults();
  if (tab.id === "tab-scope") scope.open();
  if (tab.id === "tab-commission") commission.list();
  if (tab.id === "tab-recordings") recordings.list();
}
for (const tab of tabs) {
  tab.addEventListener("click", () => choose(tab));
  tab.addEventListener("keydown", (event) => {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!by) return;
    const shown = tabs.filter((each) => !each.hidden);
    const next = shown[(shown.indexOf(tab) + by + shown.length) % shown.length];
    next.focus();
    choose(next);
  });
}

async function readFaults() {
  const found = await ask("faults");
  if (found) showFaults($("faults"), $("faults-note"), found);
}
$("faults-read").addEventListener("click", readFaults);

window.trackservo = { plots, connection, state: () => state };
