/* Draws the plots in the colours of the current scheme and runs the tabs. */
(function () {
  const stand_ins = { "rgb(1,1,1)": "--ink", "rgb(2,2,2)": "--muted", "rgb(3,3,3)": "--grid", "rgb(4,4,4)": "--surface", "rgb(5,5,5)": "--bad" };
  const settings = { responsive: true, displaylogo: false, doubleClick: "reset", plotlyServerURL: "",
    /* Named one by one: the default set has a button that sends the chart to a server. */
    modeBarButtons: [["zoom2d", "pan2d"], ["zoomIn2d", "zoomOut2d", "resetScale2d"], ["toImage"]] };
  const drawn = new Set();

  function draw(box) {
    const style = getComputedStyle(document.documentElement);
    let text = document.getElementById(box.dataset.json).textContent;
    for (const [from, to] of Object.entries(stand_ins)) text = text.replaceAll(from, style.getPropertyValue(to).trim());
    const figure = JSON.parse(text);
    drawn.add(box);
    Plotly.react(box, figure.data, figure.layout, settings);
  }

  /* One after the other, nearest to the window first, so that the page can be read and scrolled from the start. */
  const distance = (box) => Math.abs(box.getBoundingClientRect().top);
  const waiting = [...document.querySelectorAll(".plot:not([hidden])")];
  (function next() {
    if (!waiting.length) return;
    waiting.sort((a, b) => distance(b) - distance(a));
    draw(waiting.pop());
    setTimeout(next);
  })();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawn.forEach(draw));

  for (const tabs of document.querySelectorAll(".tabs")) {
    const buttons = [...tabs.querySelectorAll("button")];
    tabs.addEventListener("click", (event) => {
      if (!buttons.includes(event.target)) return;
      for (const button of buttons) {
        const on = button === event.target;
        const box = document.getElementById(button.dataset.plot);
        button.setAttribute("aria-selected", on);
        box.hidden = !on;
        if (on) draw(box);
      }
    });
  }

  const links = new Map([...document.querySelectorAll("nav a")].map((a) => [a.getAttribute("href").slice(1), a]));
  const spy = new IntersectionObserver((seen) => {
    for (const entry of seen) if (entry.isIntersecting) {
      links.forEach((a) => a.classList.remove("here"));
      links.get(entry.target.id).classList.add("here");
    }
  }, { rootMargin: "-10% 0px -80% 0px" });
  links.forEach((_, id) => { const at = document.getElementById(id); if (at) spy.observe(at); });
})();
