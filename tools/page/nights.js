// One figure of one case, night by night: its intervals, the levels between change points, and where it changed.
import { escaped, figure, ink } from "./words.js";

const LABEL_LANES = 3, LABEL_PIXELS = 15;
const EDGE = 0.5; // of the distance of two nights

export function nightsOf(spec, rows) {
  const order = new Map(spec.nights.map((started, at) => [started, at]));
  const dates = datesOf(spec.nights);
  const mine = rows.filter((row) => row.value !== null).map((row) => ({ at: order.get(row.started), row })).sort((a, b) => a.at - b.at);
  const first = mine[0]?.row, name = first ? spec.names[first.metric] : "";
  const title = first?.unit ? `${name} (${first.unit})` : name;
  const told = (row) => toldOf(spec, row, title);
  const changes = mine.filter(({ row }) => row.changed);
  const axisLine = { onZero: false, lineStyle: { color: ink("quiet") } }, axisLabel = { color: ink("text"), showMinLabel: false, showMaxLabel: false };
  return {
    chosen: first ? `${first.case}, ${name}: ${spec.whats[first.metric]}. ${changesInWords(changes)}` : "",
    option: {
      series: [levels(mine), intervals(mine), steps(changes), dots(mine)],
      grid: { left: 78, top: 14 + LABEL_PIXELS * Math.min(LABEL_LANES, changes.length) },
      tooltip: { trigger: "item", formatter: (one) => (one.data?.row ? htmlOf(told(one.data.row)) : "") },
      xAxis: { type: "value", min: -EDGE, max: spec.nights.length - EDGE, minInterval: 1, splitLine: { show: false }, axisLine,
        axisLabel: { ...axisLabel, hideOverlap: true, formatter: (at) => dates[at] ?? "" } },
      yAxis: { type: "value", scale: true, name: title, nameGap: 54, axisLine, ...rangeOf(mine),
        axisLabel: { ...axisLabel, formatter: (value) => String(Number(value.toPrecision(6))) } },
    },
    stops: mine.map(({ row }, index) => ({ series: 3, index, words: told(row).join("; ") })),
  };
}

// Days; with the hour where two nights are of one day.
function datesOf(nights) {
  const days = nights.map((started) => started.slice(0, 10));
  const isTwice = new Set(days).size < days.length;
  return nights.map((started) => (isTwice ? started.slice(5, 16).replace("T", " ") : started.slice(0, 10)));
}

function toldOf(spec, row, title) {
  const interval = row.low === null || row.high === null ? "" : ` (95 % interval ${figure(row.low)} to ${figure(row.high)})`;
  return [`night ${row.started}`, `${title}: ${figure(row.value)}${interval}`,
    ...Object.entries(spec.hover).filter(([column]) => row[column] !== null).map(([column, words]) => `${words}: ${row[column]}`)];
}

const htmlOf = (lines) => `<div class="tip">${lines.map((line, at) => (at === 1 ? `<b>${escaped(line)}</b>` : escaped(line))).join("<br>")}</div>`;

function changesInWords(changes) {
  if (!changes.length) return "No change was found.";
  return changes.map(({ row }) => `Changed in the night of ${row.started}: ${row.changed}.`).join(" ");
}

// Intervals may reach farther than values; a series that never changes has a line in the middle.
function rangeOf(mine) {
  const values = mine.flatMap(({ row }) => [row.value, row.low, row.high].filter((value) => value !== null));
  if (!values.length) return {};
  const low = Math.min(...values), high = Math.max(...values), room = 0.08 * (high - low) || 0.05 * Math.abs(high) || 1;
  return { min: low - room, max: high + room };
}

function dots(mine) {
  const color = ink("accent");
  return {
    name: "nights", type: "line", color, lineStyle: { width: 1, opacity: 0.5 }, showSymbol: true, showAllSymbol: true, z: 5,
    data: mine.map(({ at, row }) => ({ value: [at, row.value], row, symbol: row.changed ? "diamond" : "circle", symbolSize: row.changed ? 13 : 7,
      itemStyle: row.changed ? { color: ink("change"), borderColor: ink("card"), borderWidth: 1 } : { color } })),
  };
}

function levels(mine) {
  const data = mine.flatMap(({ at, row }, i) => [...(i && row.changed ? [[at - EDGE, mine[i - 1].row.level], [at - EDGE, row.level]] : []), [at, row.level]]);
  return { name: "level", type: "line", silent: true, showSymbol: false, data, color: ink("quiet"), lineStyle: { width: 5, opacity: 0.3 }, z: 1 };
}

function intervals(mine) {
  const known = mine.filter(({ row }) => row.low !== null && row.high !== null);
  const color = ink("accent");
  return {
    name: "interval", type: "custom", silent: true, z: 3, data: known.map(({ at, row }) => [at, row.low, row.high]),
    renderItem: (_, api) => {
      const [x1, y1] = api.coord([api.value(0), api.value(1)]), [, y2] = api.coord([api.value(0), api.value(2)]);
      return { type: "line", shape: { x1, y1, x2: x1, y2 }, style: { stroke: color, lineWidth: 1.6, opacity: 0.7 } };
    },
  };
}

// A dashed line before the first night of a change, and by how much, in lanes so that no two cover each other.
function steps(changes) {
  const lines = changes.map(({ at, row }, number) => ({ at: at - EDGE, lane: number % LABEL_LANES, words: row.ratio === null ? "changed" : `× ${figure(row.ratio)}` }));
  return {
    name: "changes", type: "custom", silent: true, z: 2, clip: false, data: lines.map((line) => [line.at]),
    renderItem: ({ dataIndex, coordSys: { x: left, y: top, width, height } }, api) => {
      const [x] = api.coord([api.value(0), 0]), { lane, words } = lines[dataIndex], color = ink("change");
      if (x < left || x > left + width) return null;
      const isRight = x > left + 0.75 * width;
      return { type: "group", children: [
        { type: "line", shape: { x1: x, y1: top - LABEL_PIXELS * (lane + 0.5), x2: x, y2: top + height }, style: { stroke: color, lineWidth: 1.3, lineDash: [5, 4] } },
        { type: "text", style: { text: words, x: isRight ? x - 4 : x + 4, y: top - LABEL_PIXELS * (lane + 1), align: isRight ? "right" : "left", verticalAlign: "top",
          fill: color, font: "600 12px system-ui, sans-serif" } },
      ] };
    },
  };
}
