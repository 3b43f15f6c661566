// Brings the page to life: what is near the screen first.
import { bindRows, startChart } from "./charts.js";
import { choiceOf } from "./choice.js";
import { startHelps } from "./helps.js";
import { startView } from "./view.js";

const NEAR = "400px";
const PAUSE_MS = 200;

const waiting = new Set(); // of what was not near yet

function whenNear(element, start) {
  const once = () => waiting.delete(once) && start();
  waiting.add(once);
  const watch = new IntersectionObserver((seen) => {
    if (!seen.some((one) => one.isIntersecting)) return;
    watch.disconnect();
    once();
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
startHelps();

// The rest as soon as there is time, one after the other, so that the page prints whole.
async function startRest() {
  for (const start of waiting) {
    await start();
    await new Promise((done) => setTimeout(done, PAUSE_MS));
  }
  document.documentElement.dataset.whole = "yes";
}
setTimeout(startRest, PAUSE_MS);

addEventListener("beforeprint", () => {
  for (const figure of document.querySelectorAll("figure.has-view")) figure.view?.still();
});
addEventListener("afterprint", () => {
  for (const still of document.querySelectorAll(".still")) still.remove();
});
document.documentElement.dataset.ready = "yes";
