// Draws runs side by side in one canvas: a cell a run, one camera for all.
import {
  ArrowHelper, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, Group, HemisphereLight, Matrix4, Mesh, MeshLambertMaterial, MeshBasicMaterial,
  OrthographicCamera, Plane, Raycaster, Scene, SphereGeometry, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import { ON_BONES, pressuresOnBones, valueAt } from "./run_data.js";
import { placeVertices } from "./unpack.js";

const BONE = new Color("#ede3c7");
const MUSCLE = new Color().setRGB(178 / 255, 88 / 255, 80 / 255, "srgb");
const SCALE = ["#9fe8f2", "#37a7d8", "#1f4fb0", "#120a5c"].map((text) => new Color(text)); // as in Fig. 6
const TOUCHING_MM = 0.02; // shallower than this counts as touching
const LEAST_PRESSURE = 1e-3; // of the upper end of the scale
const CONTACT_ARROW = "#23874b", ATTACHMENT_ARROW = "#9b3fc0"; // told in the page's legend
const LONGEST_ARROW = 0.6; // half heights of the view
const FAR = 20; // half heights of the view between the camera and what it sees
const TURN_RADIANS = 0.15;

export class Stage {
  constructor(canvas, box) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setScissorTest(true);
    this.renderer.localClippingEnabled = true;
    this.box = box;
    this.camera = new OrthographicCamera();
    this.controls = new OrbitControls(this.camera, box);
    this.controls.addEventListener("change", () => this.draw());
    box.style.touchAction = "pan-y"; // a finger that goes up or down scrolls the page
    this.cells = [];
    this.seeThrough = false;
    this.isCut = true;
  }

  // A cell has an element that tells where it is, and the run that it shows.
  show(data, cells) {
    for (const cell of this.cells) cell.dispose();
    this.data = data;
    this.cells = cells.map(({ element, run }) => new Cell(element, run, data));
    const { origin_m: origin, normal } = data.told.cut;
    this.cut = new Plane().setFromNormalAndCoplanarPoint(new Vector3(...normal), new Vector3(...origin));
    this.seeBones(this.seeThrough, this.isCut);
  }

  seeBones(isSeeThrough, isCut) {
    Object.assign(this, { seeThrough: isSeeThrough, isCut });
    for (const cell of this.cells) cell.seeBones(isSeeThrough, isCut ? [this.cut] : []);
    this.draw();
  }

  setFrame(frame, marked, kind) {
    for (const cell of this.cells) cell.setFrame(frame, marked, this.half, kind);
    this.draw();
  }

  // `side`: 1 for that of the muscle, -1 for the opposite one.
  resetCamera(side) {
    const { focus_m: focus, eye, up, half_height_m: high, half_width_m: wide } = this.data.told.camera;
    const half = Math.max(high, wide);
    this.camera.up.set(...up);
    this.controls.target.set(...focus);
    this.camera.position.set(...focus).addScaledVector(new Vector3(...eye), side * FAR * half);
    this.camera.near = 0.01 * half;
    this.camera.far = 2 * FAR * half;
    this.camera.zoom = 1;
    this.half = half;
    this.controls.update();
    this.draw();
  }

  // Where the camera is, where it looks, and its zoom.
  get sight() {
    return [...this.camera.position.toArray(), ...this.controls.target.toArray(), this.camera.zoom];
  }

  set sight(values) {
    if (values.length !== 7 || !values.every(Number.isFinite)) return;
    this.camera.position.set(...values.slice(0, 3));
    this.controls.target.set(...values.slice(3, 6));
    this.controls.update();
    this.zoom(values[6] / this.camera.zoom);
  }

  turn(right, up) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    offset.applyAxisAngle(this.camera.up, -TURN_RADIANS * right);
    const side = new Vector3().crossVectors(this.camera.up, offset).normalize();
    const lifted = offset.clone().applyAxisAngle(side, -TURN_RADIANS * up);
    if (Math.abs(lifted.clone().normalize().dot(this.camera.up)) < 0.99) offset.copy(lifted);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  zoom(factor) {
    this.camera.zoom = Math.min(40, Math.max(0.2, this.camera.zoom * factor));
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    if (!this.data || this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame(() => {
      this.isWaiting = false;
      this.drawNow();
    });
  }

  drawNow() {
    const outer = this.box.getBoundingClientRect();
    if (!outer.width) return;
    this.renderer.setSize(outer.width, outer.height, false);
    this.renderer.setScissor(0, 0, outer.width, outer.height);
    this.renderer.clear();
    for (const cell of this.cells) {
      const inner = cell.element.getBoundingClientRect();
      const at = [inner.left - outer.left, outer.bottom - inner.bottom, inner.width, inner.height];
      this.aim(inner.width / inner.height);
      this.renderer.setViewport(...at);
      this.renderer.setScissor(...at);
      cell.light.position.copy(this.camera.position).addScaledVector(this.camera.up, 0.4 * FAR * this.half);
      this.renderer.render(cell.scene, this.camera);
    }
  }

  // The whole of what the view holds, however narrow a cell is.
  aim(aspect) {
    const { half_height_m: half, half_width_m: wide } = this.data.told.camera;
    const high = Math.max(half, wide / aspect);
    Object.assign(this.camera, { left: -high * aspect, right: high * aspect, top: high, bottom: -high });
    this.camera.updateProjectionMatrix();
  }

  // {cell, node} of the muscle, {cell, bone} or null.
  pick(event) {
    for (const cell of this.cells) {
      const inner = cell.element.getBoundingClientRect();
      const x = (event.clientX - inner.left) / inner.width, y = (event.clientY - inner.top) / inner.height;
      if (x < 0 || x > 1 || y < 0 || y > 1) continue;
      this.aim(inner.width / inner.height);
      const ray = new Raycaster();
      ray.setFromCamera(new Vector2(2 * x - 1, 1 - 2 * y), this.camera);
      const hits = ray.intersectObjects(this.seeThrough ? [cell.muscle] : [cell.muscle, ...cell.bones]).filter(({ object }) => object.visible);
      const isSeen = (hit) => hit.object === cell.muscle || !this.isCut || this.cut.distanceToPoint(hit.point) >= 0;
      const hit = hits.find(isSeen);
      if (!hit) return null;
      return hit.object === cell.muscle ? { cell, node: cell.nearestCorner(hit) } : { cell, bone: hit.object.name };
    }
    return null;
  }
}

// Another geometry over the same vertices, with a colour of each.
function paintable(geometry) {
  const { position, normal } = geometry.attributes, painted = new BufferGeometry();
  painted.setAttribute("position", position).setAttribute("normal", normal).setIndex(geometry.index);
  const colours = new Float32Array(3 * position.count);
  for (let i = 0; i < position.count; ++i) BONE.toArray(colours, 3 * i);
  return painted.setAttribute("color", new BufferAttribute(colours, 3));
}

// Of a value over the upper end of the scale. The colour is valid until the next call.
const mixed = new Color();
function onScale(share) {
  const at = Math.min(1, share) * (SCALE.length - 1), from = Math.min(SCALE.length - 2, Math.floor(at));
  return mixed.copy(SCALE[from]).lerp(SCALE[from + 1], at - from);
}

class Cell {
  constructor(element, run, data) {
    Object.assign(this, { element, run, data });
    this.scene = new Scene();
    this.light = new DirectionalLight("#ffffff", 2.2);
    this.scene.add(new HemisphereLight("#ffffff", "#8d8d99", 1.5), this.light);
    this.bones = data.bones.map((bone, i) => {
      const isPressed = run.onBones.some((pressed) => pressed.bone === i);
      const mesh = new Mesh(isPressed ? paintable(bone.geometry) : bone.geometry,
                            new MeshLambertMaterial({ color: isPressed ? "#ffffff" : BONE, vertexColors: isPressed, side: DoubleSide }));
      Object.assign(mesh, { name: bone.name, matrixAutoUpdate: false });
      return mesh;
    });
    const count = data.told.vertices;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("color", new BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setIndex(new BufferAttribute(data.corners, 1));
    this.muscle = new Mesh(geometry, new MeshLambertMaterial({ vertexColors: true, side: DoubleSide }));
    this.mark = new Mesh(new SphereGeometry(1, 16, 12), new MeshBasicMaterial({ color: "#ffe600", depthTest: false }));
    this.mark.renderOrder = 2;
    this.arrows = new Group();
    this.scene.add(...this.bones, this.muscle, this.mark, this.arrows);
  }

  dispose() {
    this.muscle.geometry.dispose();
    for (const { bone } of this.run.onBones) this.bones[bone].geometry.dispose();
  }

  seeBones(isSeeThrough, clippingPlanes) {
    for (const bone of this.bones) {
      Object.assign(bone.material, { clippingPlanes, transparent: isSeeThrough, opacity: isSeeThrough ? 0.25 : 1, depthWrite: !isSeeThrough });
      bone.renderOrder = isSeeThrough ? 1 : 0;
    }
  }

  // Which of the run's moments a frame is; -1 where the run had ended.
  momentOf(frame) {
    return this.run.told.frames.indexOf(frame);
  }

  setFrame(frame, marked, half, kind) {
    const moment = this.momentOf(frame), { vertices } = this.data.told;
    this.muscle.visible = moment >= 0 && kind !== ON_BONES;
    this.mark.visible = moment >= 0 && marked !== null && kind !== ON_BONES;
    if (moment < 0) return;
    this.run.told.poses[moment].forEach((pose, i) => {
      const [a, b, c, d, e, f, g, h, k, x, y, z] = pose;
      this.bones[i].matrix.copy(new Matrix4().set(a, b, c, x, d, e, f, y, g, h, k, z, 0, 0, 0, 1));
      this.bones[i].updateMatrixWorld(true);
    });
    const { position, color } = this.muscle.geometry.attributes;
    this.paintBones(moment, kind);
    placeVertices(position.array, this.run.steps, moment, vertices, this.run.told);
    this.paint(color.array, moment, kind);
    position.needsUpdate = color.needsUpdate = true;
    this.muscle.geometry.computeVertexNormals();
    this.muscle.geometry.computeBoundingSphere();
    if (marked !== null) {
      this.mark.position.fromBufferAttribute(position, marked);
      this.mark.scale.setScalar(0.022 * half);
    }
    this.pointForces(kind === "pressure" || kind === ON_BONES ? this.run.told.arrows[moment] : [], half);
  }

  // What bones and other muscles do to the muscle; the largest force of all runs has the longest arrow.
  pointForces(arrows, half) {
    this.arrows.traverse((part) => (part.geometry?.dispose(), part.material?.dispose()));
    this.arrows.clear();
    for (const [x, y, z, fx, fy, fz, isAttachment] of arrows) {
      const force = new Vector3(fx, fy, fz), length = LONGEST_ARROW * half * force.length() / this.data.told.most_n;
      if (length < 0.02 * half) continue;
      const arrow = new ArrowHelper(force.normalize(), new Vector3(x, y, z), length, isAttachment ? ATTACHMENT_ARROW : CONTACT_ARROW,
                                    Math.min(0.4 * length, 0.08 * half), 0.05 * half);
      for (const part of [arrow.line, arrow.cone]) Object.assign(part.material, { depthTest: false }), part.renderOrder = 3;
      this.arrows.add(arrow);
    }
  }

  paint(colours, moment, kind) {
    const { vertices, deepest_mm: deepest, most_pa: mostPa } = this.data.told;
    const top = kind === "pressure" ? mostPa : deepest, least = kind === "pressure" ? LEAST_PRESSURE * mostPa : TOUCHING_MM;
    for (let i = 0; i < vertices; ++i) {
      const value = valueAt(this.run, kind, moment, i, vertices);
      (value > least ? onScale(value / top) : MUSCLE).toArray(colours, 3 * i);
    }
  }

  paintBones(moment, kind) {
    if (kind !== ON_BONES && !this.areBonesPainted) return;
    this.areBonesPainted = kind === ON_BONES;
    const { most_bone_pa: mostPa } = this.data.told;
    pressuresOnBones(this.run, moment, (bone, vertex, pressure) => {
      const isSeen = kind === ON_BONES && pressure > LEAST_PRESSURE * mostPa;
      (isSeen ? onScale(pressure / mostPa) : BONE).toArray(this.bones[bone].geometry.attributes.color.array, 3 * vertex);
    });
    for (const { bone } of this.run.onBones) this.bones[bone].geometry.attributes.color.needsUpdate = true;
  }

  nearestCorner(hit) {
    const { position } = this.muscle.geometry.attributes, corner = new Vector3();
    const away = (node) => corner.fromBufferAttribute(position, node).distanceToSquared(hit.point);
    return [hit.face.a, hit.face.b, hit.face.c].reduce((best, node) => (away(node) < away(best) ? node : best));
  }
}
