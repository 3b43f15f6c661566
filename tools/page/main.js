// Brings the page to life: what is near the screen first.
import { bindRows, startChart } from "./charts.js";
import { choiceOf } from "./choice.js";
import { startView } from "./view.js";

const NEAR = "400px";

function whenNear(element, start) {
  const watch = new IntersectionObserver((seen) => {
    if (!seen.some((one) => one.isIntersecting)) return;
    watch.disconnect();
    start();
  }, { rootMargin: NEAR });
  watch.observe(element);
}

for (const section of document.querySelectorAll("section.results")) {
  const choice = choiceOf(section);
  for (const figure of section.querySelectorAll("figure.has-chart")) whenNear(figure, () => startChart(figure, choice));
  for (const figure of section.querySelectorAll("figure.has-view")) whenNear(figure, () => startView(figure, choice));
  for (const figure of section.querySelectorAll("figure.has-table")) bindRows(figure, choice);
  for (const cell of section.querySelectorAll(".cell-of-matrix")) {
    const tell = () => { cell.closest("figure").querySelector(".readout").textContent = cell.dataset.words; };
    for (const event of ["mouseenter", "focus", "click"]) cell.addEventListener(event, tell);
  }
}
document.documentElement.dataset.ready = "yes";
