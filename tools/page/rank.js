// Which setting is the cheapest for an error that one can live with. Rows are those of the board; nothing here draws.

// What one may ask for: the column of the error, its unit, the column of the time that goes with it, and the ends of the slider.
export const ERRORS = {
  surface: { title: "surface offset, 99th percentile", unit: "mm", column: "offset_mm", time: "time_ms", low: 1e-3, high: 20 },
  arm: { title: "moment arm off by, RMS", unit: "mm", column: "arm_mm", floor: "arm_floor_mm", time: "own_ms", low: 1e-2, high: 20 },
  pressure: { title: "peak contact pressure off by, RMS", unit: "%", column: "pressure_percent", floor: "pressure_floor_percent", time: "own_ms", low: 0.1, high: 100 },
  torque: { title: "joint torque off by, RMS", unit: "%", column: "torque_percent", floor: "torque_floor_percent", time: "own_ms", low: 0.1, high: 100 },
};
export const EXACT_MM = 1e-6; // a nanometre: what double precision leaves of millimetres
const STEPS = 200; // of the slider

// The surface offset of all contacts, or of those that are hard in one way.
export function columnOf(state) {
  return state.error === "surface" && state.contacts !== "all" ? `${state.contacts}_mm` : ERRORS[state.error].column;
}

// Rows of the chosen scene and machine with what is asked for as `error`, `time_ms` and its interval. Nobody can be better than
// what rounding does by itself; where nobody knows that, an error says nothing.
export function asked(rows, state) {
  const about = ERRORS[state.error], column = columnOf(state);
  const mine = rows.filter((row) => row.scene === state.scene && row.machine === state.machine);
  const floors = about.floor ? mine.map((row) => row[about.floor]).filter((floor) => floor !== null) : [0];
  const floor = floors.length ? Math.max(...floors) : null;
  return mine
    .filter((row) => state.division === "all" || row.division === "closed")
    .map((row) => ({
      ...row, error: row[column] === null || floor === null ? null : Math.max(row[column], floor),
      time_ms: row[about.time], time_ms_low: row[`${about.time}_low`], time_ms_high: row[`${about.time}_high`],
    }));
}

export const canWin = (row) => row.why_not === null && row.error !== null && row.time_ms !== null;

// Of each backend the cheapest setting that holds the error, the cheapest first; then the backends that have none. Intervals
// that overlap that of the first say nothing of who is faster.
export function ranking(rows, state) {
  const holding = rows.filter((row) => canWin(row) && row.error <= state.at);
  const best = new Map();
  for (const row of [...holding].sort((a, b) => a.time_ms - b.time_ms)) if (!best.has(row.backend)) best.set(row.backend, row);
  const first = [...best.values()][0];
  const ranked = [...best.values()].map((row, index) => ({
    ...row, rank: index + 1, times: row.time_ms / first.time_ms, pays_after: paysAfter(row, holding),
    is_tied: index > 0 && !(row.time_ms_low > first.time_ms_high),
  }));
  const others = [...new Set(rows.map((row) => row.backend))].filter((name) => !best.has(name));
  return { ranked, unable: others.map((backend) => ({ backend, ...whyNone(rows.filter((row) => row.backend === backend), state) })) };
}

// Of each scene and each backend that has a ranking there, the time over that of the first: {scenes: [{scene, machine}], lines:
// [{backend, times: [a number a scene; null: none of its settings holds the error; undefined: it has no rows there]}]}. First who
// holds the error in most scenes, then who is the fastest on (geometric) average. A scene is shown for the chosen machine, else for
// the first that has it.
export function overScenes(rows, state, shows) {
  const scenes = [...new Set(rows.map((row) => row.scene))].map((scene) => {
    const there = [...new Set(rows.filter((row) => row.scene === scene).map((row) => row.machine))];
    return { scene, machine: there.includes(state.machine) ? state.machine : there[0] };
  });
  const found = scenes.map((where) => ranking(asked(rows, { ...state, ...where }).filter((row) => shows(row.backend)), state));
  const backends = [...new Set(found.flatMap(({ ranked, unable }) => [...ranked, ...unable].map((row) => row.backend)))];
  const lines = backends.map((backend) => ({ backend, times: found.map(({ ranked, unable }) => ranked.find((row) => row.backend === backend)?.times
    ?? (unable.some((row) => row.backend === backend) ? null : undefined)) }));
  const held = (line) => line.times.filter((times) => times > 0);
  const mean = (line) => held(line).reduce((sum, times) => sum + Math.log(times), 0) / held(line).length;
  return { scenes, lines: lines.filter((line) => held(line).length).sort((a, b) => held(b).length - held(a).length || mean(a) - mean(b)) };
}

// After so many frames it is ahead of all that hold the error and are ready sooner; Infinity: one of them is faster, too.
export function paysAfter(row, holding) {
  if (holding.some((other) => other.build_s === null)) return null;
  const sooner = holding.filter((other) => other.build_s < row.build_s);
  return Math.max(0, ...sooner.map((other) => (other.time_ms <= row.time_ms ? Infinity
    : Math.ceil((1e3 * (row.build_s - other.build_s)) / (other.time_ms - row.time_ms)))));
}

// Why an error is not known.
export const unknownOf = (rows, state) => state.error === "surface" && rows.some((row) => row.is_open)
  ? "its surface is farther away than was searched" : "this error of it was not measured";

function whyNone(rows, state) {
  const able = rows.filter(canWin);
  if (able.length) return { why: "its most accurate setting is off by", error: Math.min(...able.map((row) => row.error)) };
  return { why: rows.find((row) => row.why_not !== null)?.why_not ?? unknownOf(rows, state), error: null };
}

// Rows than which none that can win is both faster and at least as accurate.
export function frontOf(rows) {
  let best = Infinity;
  const front = new Set();
  for (const row of rows.filter(canWin).sort((a, b) => a.time_ms - b.time_ms || a.error - b.error)) {
    const error = Math.max(row.error, EXACT_MM);
    if (error < best) {
      best = error;
      front.add(row);
    }
  }
  return front;
}

// The slider is logarithmic. With fewer digits a step of 5 % would end where it began.
export const errorAt = (step, { low, high }) => Number((low * (high / low) ** (step / STEPS)).toPrecision(3));
export const stepAt = (error, { low, high }) => Math.round((STEPS * Math.log(error / low)) / Math.log(high / low));
