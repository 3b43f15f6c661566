// A view in space with its controls: frames, play, bones, a node and what is known of it in each run.
import { closestDistance, intoRestPose } from "./closest.js";
import { hasKind, largestAt, ON_BONES, sceneData, valueAt } from "./run_data.js";
import { Stage } from "./stage.js";
import { escaped, figure, label } from "./words.js";

const FRAME_MS = 120;
const CLICK_PIXELS = 5;

const known = (depth) => (Number.isNaN(depth) ? "-" : figure(depth));

export async function startView(element, choice) {
  const told = JSON.parse(document.getElementById(element.dataset.views).textContent);
  const view = new View(element, choice, told);
  if (!view.stage) return;
  choice.addEventListener("change", () => view.choose());
  await view.choose();
  element.view = view;
}

class View {
  constructor(element, choice, told) {
    Object.assign(this, { element, choice, told, marked: null });
    const part = (name) => element.querySelector(`.${name}`);
    this.parts = Object.fromEntries(["stage", "cells", "slider", "frame", "play", "node", "bones", "cut", "coloured", "readout", "scale", "outside", "scale-low", "scale-top", "arrows", "arrow-top", "missing"]
      .map((name) => [name, part(name)]));
    try {
      this.stage = new Stage(element.querySelector("canvas"), this.parts.cells);
    } catch {
      this.parts.missing.hidden = false;
      this.parts.stage.hidden = true;
      return;
    }
    this.bind(part);
  }

  bind(part) {
    const { slider, play, node, bones, cut, coloured, cells } = this.parts;
    slider.addEventListener("input", () => this.setFrame());
    play.addEventListener("click", () => this.togglePlay());
    for (const box of [bones, cut]) box.addEventListener("change", () => this.seeBones());
    coloured.addEventListener("change", () => {
      this.seeBones();
      this.setFrame();
    });
    node.addEventListener("change", () => this.mark(this.data.order.indexOf(Number(node.value))));
    part("reset").addEventListener("click", () => this.stage.resetCamera(1));
    part("behind-it").addEventListener("click", () => this.stage.resetCamera(-1));
    part("closer").addEventListener("click", () => this.stage.zoom(1.25));
    part("farther").addEventListener("click", () => this.stage.zoom(0.8));
    this.bindMouse(cells);
    cells.addEventListener("keydown", (event) => this.onKey(event));
    new ResizeObserver(() => this.stage.draw()).observe(cells);
  }

  bindMouse(cells) {
    let down = null;
    cells.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
    cells.addEventListener("pointerup", (event) => {
      const isClick = down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < CLICK_PIXELS;
      if (isClick) this.onPick(this.stage.pick(event));
    });
    // A wheel that turns over the picture scrolls the page, unless it was asked for.
    cells.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== cells) event.stopImmediatePropagation();
    }, { capture: true });
  }

  onKey(event) {
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (turns[event.key]) this.stage.turn(...turns[event.key]);
    else if (event.key === "+" || event.key === "=") this.stage.zoom(1.25);
    else if (event.key === "-") this.stage.zoom(0.8);
    else if (event.key === "0") this.stage.resetCamera(1);
    else if (event.key === " ") this.togglePlay();
    else return;
    event.preventDefault();
  }

  async choose() {
    const told = this.told.scenes.find((scene) => scene.muscle === this.choice.muscle);
    this.element.classList.toggle("empty", !told);
    if (!told) return;
    const isNew = this.data?.told !== told;
    if (isNew) {
      this.stop();
      this.marked = null;
      this.data = await sceneData(told, this.told.meshes);
      if (this.choice.muscle !== told.muscle) return;
      Object.assign(this.parts.slider, { max: this.data.frames.length - 1, value: this.firstMoment() });
      Object.assign(this.parts.node, { value: "", max: told.vertices - 1 });
      const kept = [...this.parts.coloured.options].filter((option) => {
        option.hidden = option.disabled = !this.data.runs.some((run) => hasKind(run, option.value));
        return !option.hidden;
      });
      this.parts.coloured.parentElement.hidden = kept.length < 2;
      if (!kept.some((option) => option.selected)) this.parts.coloured.value = kept[0]?.value ?? "node";
    }
    this.layOut();
    if (isNew) this.stage.resetCamera(1);
    this.seeBones();
    this.setFrame();
    this.element.dataset.drawn = told.muscle;
  }

  // Where the motion is farthest: there is most to be seen.
  firstMoment() {
    const { frames, angles_deg: angles } = this.data.told.runs.reduce((a, b) => (b.told?.frames.length > a.frames.length ? b : a));
    const farthest = angles.reduce((best, angle, i) => (Math.abs(angle - angles[0]) > Math.abs(angles[best] - angles[0]) ? i : best), 0);
    return this.data.frames.indexOf(frames[farthest]);
  }

  layOut() {
    const shown = this.data.runs.filter((run) => this.choice.shows(run.told.backend));
    const cells = shown.map((run) => {
      const element = document.createElement("div");
      element.className = "cell";
      const name = this.choice.name(run.told.backend);
      element.innerHTML = `<span class="cell-name"><span class="dot" style="background:${escaped(this.choice.colour(run.told.backend))}"></span>` +
        `${escaped(name)}</span><span class="cell-depth"></span>`;
      return { element, run };
    });
    this.parts.cells.style.setProperty("--columns", String(Math.min(4, Math.max(1, shown.length))));
    this.parts.cells.replaceChildren(...cells.map((cell) => cell.element));
    this.stage.show(this.data, cells);
  }

  get frame() {
    return this.data.frames[Number(this.parts.slider.value)];
  }

  // What colours tell.
  get kind() {
    return this.parts.coloured.value;
  }

  // Colours on a bone need a bone that one does not see through.
  seeBones() {
    this.stage.seeBones(this.parts.bones.checked && this.kind !== ON_BONES, this.parts.cut.checked);
  }

  setFrame() {
    const { vertices } = this.data.told, { kind } = this, isPressure = kind === "pressure" || kind === ON_BONES;
    this.tellScale(isPressure, kind === ON_BONES);
    this.stage.setFrame(this.frame, this.marked, kind);
    const angle = this.data.runs.map(({ told }) => told.angles_deg[told.frames.indexOf(this.frame)]).find((one) => one !== undefined);
    this.parts.frame.textContent = `frame ${this.frame}, joint at ${figure(Math.round(10 * angle) / 10)}°`;
    this.parts.slider.setAttribute("aria-valuetext", this.parts.frame.textContent);
    const told = this.stage.cells.map((cell) => {
      const moment = cell.momentOf(this.frame);
      const ended = moment < 0 && `ended: ${cell.run.told.status}`;
      const least = kind === "surface" && cell.run.told.open_surface_frames.includes(this.frame) ? "at least " : "";
      const largest = () => figure(largestAt(cell.run, kind, moment, vertices));
      const kept = isPressure ? () => `largest pressure ${largest()} Pa` : () => `deepest ${least}${largest()} mm`;
      const text = ended || (hasKind(cell.run, kind) ? kept() : isPressure ? `no pressure: ${cell.run.told.no_pressure}` : "depth not stored");
      cell.element.querySelector(".cell-depth").textContent = text;
      return `${this.choice.name(cell.run.told.backend)}: ${text}`;
    });
    this.parts.cells.setAttribute("aria-label", `${label(this.data.told.muscle)} on its bones, ${this.parts.frame.textContent}; ${told.join("; ")}`);
    this.tellNode();
  }

  tellScale(isPressure, isOnBones) {
    const { deepest_mm: deepest, most_n: mostN } = this.data.told, mostPa = isOnBones ? this.data.told.most_bone_pa : this.data.told.most_pa;
    this.parts["scale-low"].textContent = isPressure ? "not pressed" : "outside, or less than 0.02 mm inside";
    this.parts["scale-top"].textContent = isPressure ? `pressed with ${figure(mostPa)} Pa or more.` : `${figure(deepest)} mm or more deep in a bone`;
    for (const name of ["outside", "scale-low"]) this.parts[name].hidden = isOnBones;
    this.parts.arrows.hidden = !isPressure;
    this.parts["arrow-top"].textContent = `${figure(mostN)} N`;
    this.parts.scale.setAttribute("aria-label", isPressure
      ? `Colours: light to dark blue is the pressure on ${isOnBones ? "the bones" : "the muscle; red is not pressed"}. Arrows: forces on the muscle`
      : "Colours: red is outside of bones or less than 0.02 mm inside; light to dark blue is the chosen depth in a bone");
  }

  onPick(found) {
    if (found?.node !== undefined) this.mark(found.node);
    else if (found) this.parts.readout.textContent = `This is the ${label(found.bone)}.${this.kind === ON_BONES ? "" : " Click on the muscle, or make the bones transparent."}`;
  }

  mark(node) {
    if (node < 0 || node >= this.data.told.vertices) {
      this.parts.readout.textContent = `Nodes are numbered from 0 to ${this.data.told.vertices - 1}.`;
      return;
    }
    this.marked = node;
    this.parts.node.value = this.data.order[node];
    this.setFrame();
  }

  tellNode() {
    if (this.marked === null) {
      this.parts.readout.textContent = "Click on a node of a muscle, or type its number, to read its depth and its distance from the nearest bone.";
      return;
    }
    const lines = this.stage.cells.filter((cell) => cell.momentOf(this.frame) >= 0).map((cell) => this.nodeOf(cell));
    const bound = this.data.attached[this.marked] ? ", bound to a bone" : "";
    this.parts.readout.innerHTML = `<table><caption>Node ${escaped(this.data.order[this.marked])}${bound}, frame ${escaped(this.frame)}</caption><thead><tr><th>backend</th>` +
      "<th>depth in a bone (mm)</th><th>of the surface around it (mm)</th><th>pressure (Pa)</th><th>distance to the nearest bone (mm)</th><th>bone</th></tr></thead><tbody>" +
      lines.map((line) => `<tr><th scope="row">${escaped(line.backend)}</th><td class="number">${known(line.depth)}</td>` +
        `<td class="number">${known(line.around)}</td><td class="number">${known(line.pressure)}</td>` +
        `<td class="number">${line.distance.toFixed(2)}</td><td>${escaped(line.bone)}</td></tr>`).join("") + "</tbody></table>";
  }

  nodeOf(cell) {
    const { position } = cell.muscle.geometry.attributes, moment = cell.momentOf(this.frame);
    const point = [position.getX(this.marked), position.getY(this.marked), position.getZ(this.marked)];
    const found = this.data.bones.map((bone, i) => ({ bone: label(bone.name),
      distance: 1e3 * closestDistance(intoRestPose(point, cell.run.told.poses[moment][i]), bone.positions, bone.corners) }));
    const nearest = found.reduce((a, b) => (b.distance < a.distance ? b : a));
    const value = (kind) => valueAt(cell.run, kind, moment, this.marked, this.data.told.vertices);
    return { backend: this.choice.name(cell.run.told.backend), depth: value("node"), around: value("surface"), pressure: value("pressure"), ...nearest };
  }

  // A canvas of WebGL is blank on paper, and keeps its picture no longer than it takes to draw it.
  still() {
    this.stage.drawNow();
    const picture = Object.assign(new Image(), { className: "still", alt: "", src: this.element.querySelector("canvas").toDataURL() });
    this.parts.stage.prepend(picture);
  }

  togglePlay() {
    if (this.timer) {
      this.stop();
      return;
    }
    this.parts.play.textContent = "Pause";
    this.timer = setInterval(() => {
      this.parts.slider.value = (Number(this.parts.slider.value) + 1) % this.data.frames.length;
      this.setFrame();
    }, FRAME_MS);
  }

  stop() {
    clearInterval(this.timer);
    this.timer = null;
    this.parts.play.textContent = "Play";
  }
}
