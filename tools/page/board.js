// The board: an error that one can live with, and what it costs with each backend. What is chosen stands in the address.
import { addressed, writeAddress } from "./address.js";
import { startChart } from "./charts.js";
import { choiceOf } from "./choice.js";
import { EXACT_MM, ERRORS, asked, canWin, errorAt, frontOf, overScenes, ranking, stepAt, unknownOf } from "./rank.js";
import { rowsOf } from "./rows.js";
import { escaped, figure } from "./words.js";

const DEFAULTS = { error: "surface", contacts: "all", division: "all", at: 0.1, off: "" };
const HOVER = { error_words: "holds", structure_mb: "structures (MB)", build_s: "build (s)", standing: "answers", bound: "declared bound", measured: "measured" };

const boundOf = (row) => (row.declared_missed_mm === null ? row.bound : `${figure(Math.max(row.declared_missed_mm, row.declared_false_mm))} mm, ${row.bound}`);
const nameOf = (row) => `${row.spoken ?? row.configuration}${row.stride > 1 ? `, every ${row.stride}th frame` : ""}`;

class Board {
  constructor(section, rows, choice) {
    Object.assign(this, { section, rows, choice });
    const part = (name) => section.querySelector(`.${name}`);
    this.parts = Object.fromEntries(["scene", "machine", "error", "contacts", "division", "at", "at-number", "at-unit", "ranking", "unable", "told", "where", "scenes"].map((name) => [name, part(`board-${name}`)]));
    this.fixed = { ...DEFAULTS, scene: this.parts.scene.value, machine: this.parts.machine.value };
    this.state = this.fixed;
    for (const name of ["scene", "machine", "error", "contacts", "division"]) this.parts[name].addEventListener("change", () => this.choose({ [name]: this.parts[name].value }));
    this.parts.at.addEventListener("input", () => this.choose({ at: errorAt(Number(this.parts.at.value), ERRORS[this.state.error]) }));
    this.parts["at-number"].addEventListener("change", () => this.choose({ at: Number(this.parts["at-number"].value) }));
    addEventListener("hashchange", () => this.follow());
    choice.addEventListener("change", () => this.isOwn || this.choose({ off: [...choice.hidden].join(",") }));
    this.follow();
  }

  // What the address says.
  follow() {
    const told = this.kept({ ...this.fixed, ...addressed() }), known = Object.keys(this.choice.looks);
    this.choice.hidden = new Set(told.off.split(",").filter((name) => known.includes(name)));
    for (const button of this.section.querySelectorAll(".choose-backend")) button.setAttribute("aria-pressed", String(this.choice.shows(button.value)));
    this.state = { ...told, off: [...this.choice.hidden].join(",") };
    this.choose({});
  }

  // An address may hold anything.
  kept(state) {
    for (const name of ["scene", "machine", "error", "contacts", "division"]) {
      if (![...this.parts[name].options].some((option) => option.value === state[name])) state[name] = this.fixed[name];
    }
    const there = new Set(this.rows.filter((row) => row.scene === state.scene).map((row) => row.machine));
    for (const option of this.parts.machine.options) option.hidden = option.disabled = !there.has(option.value);
    if (!there.has(state.machine)) [state.machine] = there;
    const at = Number(state.at);
    return { ...state, at: at > 0 && Number.isFinite(at) ? at : this.fixed.at };
  }

  choose(change) {
    this.state = this.kept({ ...this.state, ...change });
    if (change.error) this.state.at = errorAt(100, ERRORS[this.state.error]);
    writeAddress(this.state, this.fixed);
    const { state, parts } = this, about = ERRORS[state.error];
    for (const name of ["scene", "machine", "error", "contacts", "division"]) parts[name].value = state[name];
    parts.contacts.parentElement.hidden = state.error !== "surface";
    Object.assign(parts.at, { value: stepAt(state.at, about) });
    parts.at.setAttribute("aria-valuetext", `${figure(state.at)} ${about.unit}`);
    parts["at-number"].value = state.at;
    parts["at-unit"].textContent = about.unit;
    this.mine = asked(this.rows, state);
    const front = frontOf(this.mine.filter((row) => this.choice.shows(row.backend)));
    for (const row of this.mine) this.dress(row, front.has(row), about);
    this.isOwn = true; // the chart follows the choice
    this.choice.change();
    this.isOwn = false;
    this.tell(about);
  }

  dress(row, isOnFront, about) {
    Object.assign(row, {
      on_front: isOnFront, is_wrong: row.why_not !== null, is_control: false, is_substitute: row.error === null,
      structure_mb: row.structure_bytes === null ? null : row.structure_bytes / 1e6,
      why_unknown: row.is_open && this.state.error === "surface" ? unknownOf([row], this.state) : null,
      error_words: row.error === null ? "unknown" : `${figure(row.error)} ${about.unit}`,
    });
  }

  feed() {
    const { state } = this, about = ERRORS[state.error];
    const title = `${about.title}${state.contacts !== "all" && state.error === "surface" ? `, contacts: ${state.contacts.replaceAll("_", " ")}` : ""} (${about.unit})`;
    // Only a surface offset is unknown for a reason: what can't be asked about single points has none.
    return {
      rows: this.mine.filter((row) => row.time_ms !== null && (row.error !== null || state.error === "surface")),
      spec: { kind: "points", x: { column: "time_ms", title: "collision time a frame (ms)" }, y: { column: "error", title }, hover: HOVER,
        exact_mm: EXACT_MM, exact_words: about.unit === "mm" ? "exact: below a nanometre" : "no difference", cut: state.at },
    };
  }

  tell(about) {
    const shown = this.mine.filter((row) => this.choice.shows(row.backend)), { ranked, unable } = ranking(shown, this.state);
    const error = `${figure(this.state.at)} ${about.unit}`;
    this.parts.told.textContent = ranked.length
      ? `${this.choice.name(ranked[0].backend)} is the cheapest that holds ${error}: ${nameOf(ranked[0])}, ${figure(ranked[0].time_ms)} ms a frame.` +
        (ranked[1]?.is_tied ? ` The interval of ${this.choice.name(ranked[1].backend)} overlaps.` : "")
      : `Nothing here holds ${error}.`;
    this.parts.where.textContent = `${this.state.scene}, ${this.state.machine}`; // on paper there is no form
    this.parts.ranking.innerHTML = ranked.map((row) => this.lineOf(row, about)).join("");
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => this.tellScenes()); // after the picture
    const cannot = shown.filter((row) => !canWin(row) && !unable.some((one) => one.backend === row.backend));
    this.parts.unable.innerHTML = [
      ...unable.map(({ backend, why, error: off }) => [this.choice.name(backend), off === null ? why : `${why} ${figure(off)} ${about.unit}`]),
      ...cannot.map((row) => [nameOf(row), row.why_not ?? unknownOf([row], this.state)]),
    ].map(([name, why]) => `<li>${escaped(name)}: ${escaped(why)}</li>`).join("");
  }

  tellScenes() {
    const { scenes, lines } = overScenes(this.rows, this.state, (backend) => this.choice.shows(backend));
    const heads = scenes.map(({ scene, machine }) => `<th scope="col" class="number">${escaped(scene)}${machine === this.state.machine ? "" : `<br><span class="quiet">${escaped(machine)}</span>`}</th>`);
    const cell = (times) => `<td class="number">${times === undefined ? "" : times === null ? "does not hold it" : times.toPrecision(3)}</td>`;
    const body = lines.map((line) => `<tr><th scope="row">${this.linkOf(line.backend)}</th>${line.times.map(cell).join("")}</tr>`);
    this.parts.scenes.innerHTML = `<thead><tr><th scope="col">backend</th>${heads.join("")}</tr></thead><tbody>${body.join("")}</tbody>`;
  }

  linkOf(backend) {
    return `<a href="${escaped(this.choice.looks[backend].page)}"><span class="dot" style="background:${escaped(this.choice.colour(backend))}"></span>${escaped(this.choice.name(backend))}</a>`;
  }

  lineOf(row, about) {
    const pays = row.pays_after === null ? "unknown" : row.pays_after === Infinity ? "never" : row.pays_after === 0 ? "at once" : String(row.pays_after);
    const cells = [
      [row.rank, true], [this.linkOf(row.backend)],
      [escaped(nameOf(row))], [`${figure(row.time_ms)}${row.is_disturbed ? " *" : ""} <span class="quiet">(${figure(row.time_ms_low)} to ${figure(row.time_ms_high)})</span>`, true], [`${row.times.toPrecision(3)}${row.is_tied ? " (overlaps)" : ""}`, true],
      [row.error < EXACT_MM ? "exact" : `${figure(row.error)} ${about.unit}`, true],
      [escaped(this.state.error === "surface" ? `${row.standing}; ${row.division}` : "claimed; open")], [figure(row.build_s), true], [pays, true], [figure(row.structure_mb), true],
      [escaped(boundOf(row)), true], [escaped(`${row.measured}${row.is_old ? ", other query set" : ""}`)],
    ];
    return `<tr${row.is_old ? ' class="old"' : ""}>${cells.map(([text, isNumber]) => `<td${isNumber ? ' class="number"' : ""}>${text}</td>`).join("")}</tr>`;
  }
}

async function startBoard(section) {
  const choice = choiceOf(section), rows = await rowsOf("board");
  const board = new Board(section, rows, choice);
  await startChart(section.querySelector("figure.has-chart"), choice, () => board.feed());
  section.board = board;
}

for (const section of document.querySelectorAll("section.board")) startBoard(section);
document.documentElement.dataset.ready = "yes";
