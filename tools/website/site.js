// SPDX-License-Identifier: Apache-2.0
// What is wider than the page scrolls by itself: lets the keyboard reach it, and nothing else.
function reach() {
  for (const each of document.querySelectorAll(".md-typeset__scrollwrap, .formula")) {
    if (each.scrollWidth > each.clientWidth) each.tabIndex = 0;
    else each.removeAttribute("tabindex");
  }
}
addEventListener("load", reach);
addEventListener("resize", reach);
