// Time against error, both log: a point a configuration, a curve over a backend's resolutions, the front in grey. What is
// exact has no logarithm: it lies at one height in a band at the bottom.
import { escaped, figure, ink } from "./words.js";

const SYMBOLS = ["circle", "rect", "diamond", "triangle", "roundRect", "arrow"];
const CROSS = "path://M-1,-1L1,1M-1,1L1,-1";
const BAND_DECADES = 1.2;
const BAND_SHARE = 0.68; // of the band's height: below it are its words
const TOP_MARGIN = 1.4;

export function pointsOf(spec, rows, choice) {
  const { exact_mm: exact, exact_words: exactWords } = spec;
  const points = rows.filter((row) => !row.is_control && row[spec.x.column] > 0);
  const errors = points.filter((row) => !row.is_substitute).map((row) => row[spec.y.column]).filter((error) => error >= exact);
  const low = 10 ** Math.floor(Math.log10(errors.length ? Math.min(...errors) : 1e-3) - 1e-9);
  const high = 2.5 * (errors.length ? Math.max(...errors) : 1);
  const hasBand = points.some((row) => !row.is_substitute && row[spec.y.column] < exact);
  const bottom = hasBand ? low / 10 ** BAND_DECADES : low;
  const sorted = [...points].sort((a, b) => a[spec.x.column] - b[spec.x.column]);
  const inBand = bottom ** (1 - BAND_SHARE) * low ** BAND_SHARE;
  const heights = new Map(sorted.map((row) => [row, heightOf(row, row[spec.y.column], exact, inBand, high / TOP_MARGIN)]));
  const place = (row) => [row[spec.x.column], heights.get(row)];
  const series = [...frontOf(sorted, heights, spec), ...curvesOf(points, place, choice), barsOf(points, spec, heights, choice)];
  const first = series.length;
  series.push(...marksOf(sorted, place, choice, (row) => spec.cut > 0 && !(row[spec.y.column] <= spec.cut)));
  if (hasBand) {
    series[first].markArea = {
      silent: true, itemStyle: { color: ink("band") }, label: { position: "insideBottomLeft", color: ink("quiet"), fontSize: 11 },
      data: [[{ name: exactWords, yAxis: bottom }, { yAxis: low }]],
    };
  }
  if (spec.cut > 0 && series[first]) {
    series[first] = { ...series[first], markLine: {
      silent: true, symbol: "none", data: [{ yAxis: Math.min(high, Math.max(spec.cut, inBand)) }], animation: false,
      lineStyle: { color: ink("accent"), type: "solid", width: 2 }, label: { position: "insideEndTop", color: ink("accent"), formatter: "the error I can live with" },
    } };
  }
  const times = points.flatMap((row) => [row[spec.x.column], row.time_ms_low, row.time_ms_high]).filter((time) => time > 0);
  const told = (row) => tellOf(spec, row, exact, exactWords);
  return {
    option: {
      series,
      tooltip: { trigger: "item", formatter: (one) => (one.data?.row ? told(one.data.row).map(escaped).join("<br>") : "") },
      xAxis: { type: "log", min: times.length ? 0.6 * Math.min(...times) : undefined, max: times.length ? 1.6 * Math.max(...times) : undefined,
        axisLabel: { color: ink("text"), formatter: decade, hideOverlap: true } },
      grid: { left: 92 },
      yAxis: { type: "log", min: bottom, max: high, nameGap: 68,
        axisLabel: { color: ink("text"), formatter: (value) => (value < 0.99 * low ? "" : decade(value)) } },
    },
    stops: sorted.map((row) => {
      const at = series.findIndex((one, index) => index >= first && one.data.some((point) => point.row === row));
      return { series: at, index: series[at].data.findIndex((point) => point.row === row), words: told(row).join("; ") };
    }),
  };
}

// Of what can't be asked about points the error is not known: it stands at the top.
function heightOf(row, error, exact, inBand, top) {
  if (row.is_substitute) return top;
  return error >= exact ? error : inBand;
}

const decade = (value) => (Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-6 ? String(Number(value.toPrecision(6))) : "");

function tellOf(spec, row, exact, exactWords) {
  const known = row[spec.y.column] < exact ? exactWords : figure(row[spec.y.column]);
  const error = row.is_substitute ? "not known" : known;
  const interval = row.time_ms_low === null ? "" : ` (95 % interval ${figure(row.time_ms_low)} to ${figure(row.time_ms_high)})`;
  return [row.spoken ?? row.configuration, `${spec.x.title}: ${figure(row[spec.x.column])}${interval}`, `${spec.y.title}: ${error}`,
    ...Object.entries(spec.hover).map(([column, title]) => `${title}: ${figure(row[column])}`),
    ...(row.is_wrong ? [row.why_not ?? "answers wrongly"] : []),
    ...(row.is_substitute ? [row.why_unknown ?? "can't be asked about single points"] : []), ...(row.on_front && !row.is_substitute ? ["on the Pareto front"] : [])];
}

function frontOf(sorted, heights, spec) {
  const front = sorted.filter((row) => row.on_front && !row.is_substitute).map((row) => [row[spec.x.column], heights.get(row)]);
  if (!front.length) return [];
  return [{ type: "line", step: "end", data: front, silent: true, showSymbol: false, color: ink("quiet"), z: 1,
    lineStyle: { width: 5, opacity: 0.3 } }];
}

function curvesOf(points, place, choice) {
  const names = [...new Set(points.filter((row) => row.series).map((row) => row.series))];
  return names.map((name) => {
    const mine = points.filter((row) => row.series === name).sort((a, b) => a.fineness - b.fineness);
    return { type: "line", data: mine.map(place), silent: true, showSymbol: false, color: choice.colour(mine[0].backend), z: 2,
      lineStyle: { width: 1, type: styleOf(points, mine[0]) ? "dashed" : "solid" } };
  });
}

// The number of a curve among those of its backend.
function styleOf(points, row) {
  return [...new Set(points.filter((one) => one.backend === row.backend && one.series).map((one) => one.series))].indexOf(row.series);
}

function barsOf(points, spec, heights, choice) {
  const known = points.filter((row) => row.time_ms_low > 0 && row.time_ms_high > 0);
  return {
    type: "custom", silent: true, z: 3,
    data: known.map((row) => [row.time_ms_low, heights.get(row), row.time_ms_high]),
    renderItem: (params, api) => {
      const [x1, y1] = api.coord([api.value(0), api.value(1)]);
      const [x2] = api.coord([api.value(2), api.value(1)]);
      return { type: "line", shape: { x1, y1, x2, y2: y1 }, style: { stroke: choice.colour(known[params.dataIndex].backend), lineWidth: 1.4 } };
    },
  };
}

// `isOut`: beyond the error that is asked for.
function marksOf(sorted, place, choice, isOut) {
  const backends = [...new Set(sorted.map((row) => row.backend))];
  return backends.map((backend) => {
    const color = choice.colour(backend);
    const mine = sorted.filter((row) => row.backend === backend);
    return {
      name: backend, type: "scatter", z: 4,
      data: mine.map((row) => ({
        value: place(row), row, symbolSize: sizeOf(row.structure_bytes),
        symbol: row.is_wrong ? CROSS : SYMBOLS[Math.max(0, styleOf(sorted, row)) % SYMBOLS.length],
        itemStyle: row.is_wrong || row.is_substitute ? { color: "none", borderColor: color, borderWidth: 2 }
          : { color, opacity: isOut(row) ? 0.25 : 1, borderColor: row.on_front ? ink("text") : ink("page"), borderWidth: row.on_front ? 1.8 : 0.6 },
      })),
    };
  });
}

// A step a factor of ten of bytes.
function sizeOf(bytes) {
  return 7 + 1.6 * (bytes > 1e3 ? Math.log10(bytes / 1e3) : 0);
}
