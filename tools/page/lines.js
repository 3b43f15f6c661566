// A line a backend over frames or nights.
import { escaped, figure, ink } from "./words.js";

export function linesOf(spec, rows, choice) {
  const groups = new Map();
  for (const row of rows) {
    const kind = spec.apart ? row[spec.apart] : "here";
    const key = `${row.backend}\n${kind}`;
    if (!groups.has(key)) groups.set(key, { backend: row.backend, kind, rows: [] });
    groups.get(key).rows.push(row);
  }
  const y = (row) => heightOf(spec, row[spec.y.column]);
  const series = [];
  for (const { backend, kind, rows: mine } of groups.values()) {
    const color = choice.colour(backend);
    const data = mine.map((row) => ({ value: [row[spec.x.column], row[spec.faint] ? null : y(row)], row }));
    if (kind === "here") {
      series.push({
        id: backend, name: backend, type: "line", data, showSymbol: mine.length < 3, symbolSize: 5, connectNulls: true, color,
        lineStyle: { width: 1.8, type: choice.looks[backend]?.dash ?? "solid" }, emphasis: { disabled: true },
        endLabel: { show: true, formatter: choice.name(backend), color, fontSize: 12 },
      });
      const faint = mine.filter((row) => spec.faint && row[spec.faint] && y(row) !== null);
      if (faint.length) {
        series.push({
          name: backend, type: "scatter", symbol: "path://M-1,-1L1,1M-1,1L1,-1", symbolSize: 6, silent: true, z: 1,
          itemStyle: { color: "none", borderColor: color, borderWidth: 1, opacity: 0.55 },
          data: faint.map((row) => ({ value: [row[spec.x.column], y(row)], row })),
        });
      }
    } else {
      series.push({
        name: `${backend}, ${kind}`, type: "line", data, symbol: "diamond", symbolSize: 11, color,
        itemStyle: { color: ink("page"), borderColor: color, borderWidth: 1.6 }, lineStyle: { width: 1, type: "dotted", color },
      });
    }
  }
  const told = (found) => textOf(spec, found, choice);
  const ends = series.filter((one) => one.endLabel).map((one) => ({ id: one.id, at: one.data.findLast((point) => point.value[1] !== null)?.value }));
  return {
    ends: ends.filter((end) => end.at),
    option: {
      series,
      grid: { right: 100 },
      tooltip: { trigger: "axis", axisPointer: { type: "line" }, formatter: (found) => told(found.map((one) => one.data.row)).html },
      xAxis: { type: "value", min: "dataMin", max: "dataMax" },
      yAxis: {
        type: spec.y.is_log ? "log" : "value", min: spec.from_zero ? 0 : spec.y.is_log ? spec.floor : "dataMin", scale: !spec.from_zero,
        axisLabel: { color: ink("text"), formatter: (value) => (value === spec.floor ? "less" : String(Number(value.toPrecision(6)))) },
      },
    },
    stops: stopsOf(spec, series, told),
  };
}

// On a log axis what is not above its floor is drawn there, or not at all where it has none.
function heightOf(spec, value) {
  if (!spec.y.is_log || value === null) return value;
  if (spec.floor) return Math.max(value, spec.floor);
  return value > 0 ? value : null;
}

function textOf(spec, rows, choice) {
  const first = rows[0];
  const shared = ["angle_deg"].filter((column) => spec.hover[column] && first[column] !== null && first[column] !== undefined);
  const head = [`${spec.x.title} ${figure(first[spec.x.column])}`, ...shared.map((column) => `${spec.hover[column]} ${figure(first[column])}`)];
  const lines = rows.map((row) => {
    const source = spec.apart && row[spec.apart] !== "here" ? ` (${row[spec.apart]})` : "";
    const more = Object.entries(spec.hover).filter(([column]) => !shared.includes(column) && row[column] !== null && row[column] !== undefined)
      .map(([column, title]) => `${title} ${figure(row[column])}`);
    return { backend: row.backend, text: `${choice.name(row.backend)}${source}: ${figure(row[spec.y.column])}`, more: more.join(", ") };
  });
  const dot = (backend) => `<span class="dot" style="background:${escaped(choice.colour(backend))}"></span>`;
  const html = [escaped(head.join(", ")), `<span class="unit">${escaped(spec.y.title)}</span>`,
    ...lines.map((line) => `${dot(line.backend)}<b>${escaped(line.text)}</b>${line.more ? `<br><span class="unit">${escaped(line.more)}</span>` : ""}`)];
  return { html: html.join("<br>"), words: [...head, spec.y.title, ...lines.map((line) => line.text)].join("; ") };
}

// One stop an x of the longest line.
function stopsOf(spec, series, told) {
  const drawn = series.filter((one) => one.type === "line");
  if (!drawn.length) return [];
  const longest = drawn.reduce((best, one) => (one.data.length > best.data.length ? one : best));
  return longest.data.map((point, index) => {
    const here = drawn.flatMap((one) => one.data.filter((other) => other.value[0] === point.value[0]).map((other) => other.row));
    return { series: series.indexOf(longest), index, words: told(here).words };
  });
}
