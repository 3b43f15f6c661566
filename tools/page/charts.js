// A figure of the page: its chart, zoom, keys, what a screen reader hears, and the rows behind it.
import { BarChart, CustomChart, LineChart, ScatterChart } from "echarts/charts";
import { DataZoomComponent, GridComponent, MarkAreaComponent, MarkLineComponent, ToolboxComponent, TooltipComponent } from "echarts/components";
import { init, use } from "echarts/core";
import { SVGRenderer } from "echarts/renderers";

import { barsOf } from "./bars.js";
import { linesOf } from "./lines.js";
import { nightsOf } from "./nights.js";
import { pointsOf } from "./points.js";
import { fillTable, rowsOf, saveCsv } from "./rows.js";
import { ink } from "./words.js";

use([BarChart, CustomChart, LineChart, ScatterChart, DataZoomComponent, GridComponent, MarkAreaComponent, MarkLineComponent,
  ToolboxComponent, TooltipComponent, SVGRenderer]);

const KINDS = { lines: linesOf, points: pointsOf, bars: barsOf, nights: nightsOf };
const SWITCHED_OFF = "All series of this chart are switched off. Switch a series on above.";
const NOT_MEASURED = "No measurement for this choice.";
const PAPER_PIXELS = 640;
const NAME_PIXELS = 14;
const ZOOM_STEP = 0.25; // of what is seen, at either end

// `feed`: what to draw, {spec, rows}, asked again at each change of the choice; those of the figure unless told.
export async function startChart(figure, choice, feed = null) {
  const box = figure.querySelector(".chart");
  const own = feed ? null : { spec: JSON.parse(figure.dataset.spec), rows: await rowsOf(figure.dataset.rows) };
  const heard = figure.querySelector(".heard");
  const chart = init(box, null, { renderer: "svg" });
  let drawn = null, withApart = true;

  const draw = () => {
    const { spec, rows } = own ?? feed();
    const mine = rows.filter((row) => isChosen(figure, choice, row));
    const isApart = (row) => spec.apart && row[spec.apart] !== "here";
    const shown = mine.filter((row) => (row.backend === undefined || choice.shows(row.backend)) && (withApart || !isApart(row)));
    figure.classList.toggle("empty", shown.length === 0);
    figure.querySelector(".nothing").textContent = mine.length ? SWITCHED_OFF : NOT_MEASURED;
    drawn = KINDS[spec.kind](spec, shown, choice);
    if (drawn.height) box.style.height = `${drawn.height}px`;
    chart.resize();
    chart.setOption(framed(drawn.option, spec), { notMerge: true });
    if (drawn.ends) nameEnds(chart, drawn.ends);
    if (drawn.chosen) figure.querySelector(".chosen").textContent = drawn.chosen;
    chart.dispatchAction({ type: "takeGlobalCursor", key: "dataZoomSelect", dataZoomSelectActive: drawsWithMouse() });
  };

  const resized = (width) => {
    chart.resize({ width });
    if (drawn.ends) nameEnds(chart, drawn.ends);
  };

  const apart = figure.querySelector(".show-apart");
  apart?.addEventListener("click", () => {
    withApart = !withApart;
    apart.setAttribute("aria-pressed", String(withApart));
    draw();
  });
  for (const one of figure.querySelectorAll(".choose-rows")) one.addEventListener("change", draw);
  choice.addEventListener("change", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  new ResizeObserver(() => chart.resize()).observe(box);
  chart.on("datazoom", () => drawn.ends && nameEnds(chart, drawn.ends));
  bindZoom(figure, chart);
  bindKeys(box, chart, () => drawn.stops, heard);
  bindRows(figure, choice);
  // A chart is drawn for a width: on paper it would be cut.
  addEventListener("beforeprint", () => resized(PAPER_PIXELS));
  addEventListener("afterprint", () => resized("auto"));
  draw();
  figure.chart = chart;
  figure.dataset.drawn = "yes";
}

// The muscle of the section, and what the figure's own lists say.
function isChosen(figure, choice, row) {
  const ofMuscle = row.muscle === undefined || choice.muscle === null || row.muscle === choice.muscle;
  return ofMuscle && [...figure.querySelectorAll(".choose-rows")].every((one) => String(row[one.dataset.column]) === one.value);
}

// The names at the right ends of lines, pushed apart so that none covers another; none while only a part is seen.
function nameEnds(chart, ends) {
  const isWhole = chart.getOption().dataZoom.every((zoom) => zoom.start === 0 && zoom.end === 100);
  if (!isWhole) {
    chart.setOption({ series: ends.map(({ id }) => ({ id, endLabel: { show: false } })) });
    return;
  }
  const placed = ends.map((end) => ({ ...end, y: chart.convertToPixel({ gridIndex: 0 }, end.at)[1] })).sort((a, b) => a.y - b.y);
  const bottom = chart.getHeight() - 48;
  let lowest = -Infinity;
  for (const end of placed) end.wanted = lowest = Math.max(end.y, lowest + NAME_PIXELS);
  let highest = bottom + 0.9 * NAME_PIXELS;
  for (const end of placed.reverse()) end.wanted = highest = Math.min(end.wanted, highest - NAME_PIXELS);
  chart.setOption({ series: placed.map(({ id, wanted, y }) => ({ id, endLabel: { show: true, offset: [0, wanted - y] } })) });
}

// A rectangle drawn with a finger would take the page's scrolling away.
const drawsWithMouse = () => matchMedia("(pointer: fine)").matches;

function framed(option, spec) {
  const axis = {
    nameLocation: "middle",
    nameTextStyle: { color: ink("text") },
    axisLabel: { color: ink("text") },
    axisLine: { lineStyle: { color: ink("quiet") } },
    splitLine: { lineStyle: { color: ink("line") } },
  };
  const zoom = { type: "inside", filterMode: "none", zoomOnMouseWheel: "ctrl", moveOnMouseMove: false, moveOnMouseWheel: false };
  return {
    ...option,
    animation: false,
    textStyle: { fontFamily: "system-ui, sans-serif", fontSize: 12, color: ink("text") },
    grid: { left: 72, right: 20, top: 14, bottom: 48, outerBoundsMode: "none", ...option.grid },
    toolbox: { show: true, itemSize: 0, left: -99, feature: { dataZoom: { filterMode: "none", brushStyle: { opacity: 0.2 } } } },
    dataZoom: [{ ...zoom, xAxisIndex: 0 }, { ...zoom, yAxisIndex: 0 }],
    tooltip: {
      confine: true, backgroundColor: ink("card"), borderColor: ink("quiet"), textStyle: { color: ink("text"), fontSize: 13 },
      ...option.tooltip,
    },
    xAxis: { ...axis, name: spec.x.title, nameGap: 28, ...option.xAxis },
    yAxis: { ...axis, name: spec.y.title, nameGap: 46, ...option.yAxis },
  };
}

function bindZoom(figure, chart) {
  const zoomed = (start, end) => [0, 1].forEach((dataZoomIndex) => chart.dispatchAction({ type: "dataZoom", dataZoomIndex, start, end }));
  const range = () => chart.getOption().dataZoom[0];
  figure.querySelector(".zoom-in").addEventListener("click", () => {
    const { start, end } = range();
    zoomed(start + ZOOM_STEP * (end - start), end - ZOOM_STEP * (end - start));
  });
  figure.querySelector(".zoom-out").addEventListener("click", () => {
    const { start, end } = range();
    zoomed(Math.max(0, start - ZOOM_STEP * 2 * (end - start)), Math.min(100, end + ZOOM_STEP * 2 * (end - start)));
  });
  const all = () => zoomed(0, 100);
  figure.querySelector(".zoom-all").addEventListener("click", all);
  figure.querySelector(".chart").addEventListener("dblclick", all);
}

// Arrow keys go from point to point; what the mouse would show is shown and said.
function bindKeys(box, chart, stopsOf, heard) {
  let at = -1;
  const show = (stop) => {
    chart.dispatchAction({ type: "showTip", seriesIndex: stop.series, dataIndex: stop.index });
    heard.textContent = stop.words;
  };
  box.addEventListener("keydown", (event) => {
    const stops = stopsOf();
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (event.key === "Escape") chart.dispatchAction({ type: "hideTip" });
    if (!stops.length || (!step && event.key !== "Home" && event.key !== "End")) return;
    event.preventDefault();
    if (event.key === "Home") at = 0;
    else if (event.key === "End") at = stops.length - 1;
    else at = Math.min(stops.length - 1, Math.max(0, at + step));
    show(stops[at]);
  });
  box.addEventListener("blur", () => chart.dispatchAction({ type: "hideTip" }));
}

export function bindRows(figure, choice) {
  const name = figure.dataset.rows;
  for (const button of figure.querySelectorAll(".save-rows")) {
    button.addEventListener("click", (event) => {
      event.preventDefault();
      saveCsv(name, button.getAttribute("download"));
    });
  }
  const details = figure.querySelector("details.behind");
  if (!details) return;
  const fill = () => details.open && fillTable(details.querySelector(".behind-rows"), name, (row) => isChosen(figure, choice, row));
  details.addEventListener("toggle", fill);
  for (const one of figure.querySelectorAll(".choose-rows")) one.addEventListener("change", fill);
  choice.addEventListener("change", fill);
}
