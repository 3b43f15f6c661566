// Runs in space, on a page of the board: the camera and the frame stand in the address.
import { addressed, writeAddress } from "./address.js";
import { choiceOf } from "./choice.js";
import { startView } from "./view.js";

async function startShapes(section) {
  const choice = choiceOf(section), element = section.querySelector("figure.has-view"), told = addressed();
  await startView(element, choice);
  if (!element.view) return;
  const { stage, parts } = element.view;
  if (told.frame) {
    parts.slider.value = told.frame;
    element.view.setFrame();
  }
  if (told.camera) stage.sight = told.camera.split(",").map(Number);
  let waiting = null;
  const write = () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => writeAddress({ frame: parts.slider.value, camera: stage.sight.map((value) => Number(value.toPrecision(5))).join(",") }, {}), 200);
  };
  stage.controls.addEventListener("change", write);
  parts.slider.addEventListener("input", write);
}

for (const section of document.querySelectorAll("section.shapes")) startShapes(section);
document.documentElement.dataset.ready = "yes";
