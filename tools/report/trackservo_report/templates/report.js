// SPDX-License-Identifier: Apache-2.0
/* Inflates and draws the plots that come into view, in the colours of the current scheme; opens folds; runs the tabs. */
(function () {
  const stand_ins = { "rgb(1,1,1)": "--ink", "rgb(2,2,2)": "--muted", "rgb(3,3,3)": "--grid", "rgb(4,4,4)": "--surface", "rgb(5,5,5)": "--bad" };
  const settings = { responsive: true, displaylogo: false, doubleClick: "reset", plotlyServerURL: "",
    /* Named one by one: the default set has a button that sends the chart to a server. */
    modeBarButtons: [["zoom2d", "pan2d"], ["zoomIn2d", "zoomOut2d", "resetScale2d"], ["toImage"]] };
  const drawn = new Set();
  let library = null;

  async function inflated(id) {
    const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Response(stream).text();
  }

  /* The plotting library is run when the first plot is looked at, not before. */
  function load() {
    library = library || inflated("plotly").then((text) => {
      const script = document.createElement("script");
      script.textContent = text;
      document.head.append(script);
    });
    return library;
  }

  async function draw(box) {
    drawn.add(box);
    try {
      await load();
      const style = getComputedStyle(document.documentElement);
      let text = await inflated(box.dataset.json);
      for (const [from, to] of Object.entries(stand_ins)) text = text.replaceAll(from, style.getPropertyValue(to).trim());
      const figure = JSON.parse(text);
      await Plotly.react(box, figure.data, figure.layout, settings);
    } catch (error) {
      box.textContent = "This plot needs a browser that can inflate it (Chrome or Edge 80, Firefox 113, Safari 16.4, or newer): " + error;
    }
  }

  /* A plot in a closed fold or behind a tab is not in view. */
  const near = new IntersectionObserver((seen) => {
    for (const entry of seen) if (entry.isIntersecting && !drawn.has(entry.target)) draw(entry.target);
  }, { rootMargin: "300px" });
  document.querySelectorAll(".plot").forEach((box) => near.observe(box));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawn.forEach(draw));

  for (const tabs of document.querySelectorAll(".tabs")) {
    const buttons = [...tabs.querySelectorAll("button")];
    tabs.addEventListener("click", (event) => {
      if (!buttons.includes(event.target)) return;
      for (const button of buttons) {
        const on = button === event.target;
        button.setAttribute("aria-selected", on);
        document.getElementById(button.dataset.plot).hidden = !on;
      }
    });
  }

  /* A link into a fold opens it. */
  function open_target() {
    const at = location.hash && document.getElementById(location.hash.slice(1));
    if (!at) return;
    const own = at.querySelector(":scope > details.fold");
    if (own) own.open = true;
    for (let fold = at.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true;
    at.scrollIntoView({ behavior: "instant" });
  }
  addEventListener("hashchange", open_target);
  document.addEventListener("click", (event) => {
    const link = event.target.closest('a[href^="#"]');
    if (link && link.getAttribute("href") === location.hash) open_target();
  });
  addEventListener("beforeprint", () => document.querySelectorAll("details.fold").forEach((fold) => (fold.open = true)));
  open_target();

  const links = new Map([...document.querySelectorAll("nav a")].map((a) => [a.getAttribute("href").slice(1), a]));
  const spy = new IntersectionObserver((seen) => {
    for (const entry of seen) if (entry.isIntersecting) {
      links.forEach((a) => a.classList.remove("here"));
      links.get(entry.target.id).classList.add("here");
    }
  }, { rootMargin: "-10% 0px -80% 0px" });
  links.forEach((_, id) => { const at = document.getElementById(id); if (at) spy.observe(at); });
})();
