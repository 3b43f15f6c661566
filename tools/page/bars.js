// Horizontal bars, the largest on top.
import { escaped, figure, ink, label } from "./words.js";

const BAR_PIXELS = 26;

export function barsOf(spec, rows) {
  const sorted = rows.filter((row) => row[spec.x.column] !== null).sort((a, b) => a[spec.x.column] - b[spec.x.column]);
  const told = (row) => [`${label(row[spec.y.column])}: ${figure(row[spec.x.column])} ${spec.x.title}`,
    ...Object.entries(spec.hover).map(([column, title]) => `${title}: ${figure(row[column])}`)];
  const series = [{
    type: "bar", barMaxWidth: 16, itemStyle: { color: ink("accent") },
    label: { show: true, position: "right", color: ink("text"), formatter: (one) => figure(one.data.row[spec.x.column]) },
    data: sorted.map((row) => ({ value: row[spec.x.column], row })),
  }];
  return {
    height: Math.max(140, 70 + BAR_PIXELS * sorted.length),
    option: {
      series,
      grid: { left: 132, right: 60 },
      tooltip: { trigger: "item", formatter: (one) => told(one.data.row).map(escaped).join("<br>") },
      xAxis: { type: "value", axisLabel: { color: ink("text"), hideOverlap: true } },
      yAxis: { type: "category", name: "", data: sorted.map((row) => label(row[spec.y.column])), axisLabel: { color: ink("text"), interval: 0 } },
    },
    stops: sorted.map((row, index) => ({ series: 0, index, words: told(row).join("; ") })).reverse(),
  };
}
