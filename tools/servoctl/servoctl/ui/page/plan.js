// SPDX-License-Identifier: Apache-2.0
// Shows what would move, how far and how fast; true when the reader wants it. Not modal: STOP stays within reach.

const $ = (id) => document.getElementById(id);

function pair(term, text) {
  const found = document.createElement("div");
  found.append(Object.assign(document.createElement("dt"), { textContent: term }), Object.assign(document.createElement("dd"), { textContent: text }));
  return found;
}

// A key that comes so soon is still the one that has opened the plan, and a click on one that has replaced another is meant
// for that.
const READ_MS = 300;
let drop = () => {};

// One plan of the server or several; `more` follows them, or stands alone. `time` replaces the duration.
export function confirmPlan(plans, more = "", time = undefined) {
  const all = [plans].flat();
  $("plan-text").textContent = all.map((plan) => `${plan.axis} will move: ${plan.text}`).join("; ") + more;
  $("plan-figures").replaceChildren(...all.flatMap((plan) => [
    ...(all.length > 1 ? [pair("axis", plan.axis)] : []),
    pair("forward", `${plan.forward_deg.toPrecision(4)}°`), pair("back", `${plan.backward_deg.toPrecision(4)}°`),
    pair("at most", `${plan.rate_deg_s.toPrecision(4)} °/s`), pair("about", time ?? `${plan.duration_s.toPrecision(3)} s`),
  ]));
  const dialog = $("plan");
  const replaces = dialog.open;
  drop();
  return new Promise((resolve) => {
    drop = () => resolve(false);
    const end = (wanted) => {
      dialog.onclose = null;
      dialog.close();
      resolve(wanted);
    };
    $("plan-cancel").onclick = () => end(false);
    const shown = performance.now();
    const isRead = () => performance.now() - shown >= READ_MS;
    $("plan-go").onclick = () => { if (!replaces || isRead()) end(true); };
    dialog.onclose = () => resolve(false);
    dialog.onkeydown = (event) => {
      if (event.key !== "Tab" && (event.repeat || !isRead())) event.preventDefault();
    };
    if (!dialog.open) dialog.show();
    $("plan-go").focus();
  });
}

export function cancelPlan() {
  if ($("plan").open) $("plan").close();
}
