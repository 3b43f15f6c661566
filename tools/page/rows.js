// Rows that the page carries as CSV: read once, shown as a table, saved as a file.
import { unpackText } from "./unpack.js";

const texts = new Map();

export function csvOf(name) {
  if (!texts.has(name)) texts.set(name, unpackText(document.getElementById(`rows-${name}`).textContent));
  return texts.get(name);
}

export async function rowsOf(name) {
  return parseCsv(await csvOf(name));
}

export function parseCsv(text) {
  const [heads, ...lines] = cellsOf(text);
  return lines.map((cells) => Object.fromEntries(heads.map((head, i) => [head.text, valueOf(cells[i])])));
}

// An empty cell is unknown, never zero. What stands in quotes is a text, also if it looks like a number.
function valueOf(cell) {
  if (cell === undefined || cell.text === "") return null;
  const number = Number(cell.text);
  return cell.isQuoted || Number.isNaN(number) ? cell.text : number;
}

function cellsOf(text) {
  const rows = [[]];
  const pattern = /("(?:[^"]|"")*"|[^,\n]*)(,|\r?\n|$)/g;
  for (let match; (match = pattern.exec(text)) && pattern.lastIndex <= text.length;) {
    const isQuoted = match[1].startsWith('"');
    rows.at(-1).push({ text: isQuoted ? match[1].slice(1, -1).replaceAll('""', '"') : match[1], isQuoted });
    if (match[2] === "") break;
    if (match[2] !== ",") {
      if (pattern.lastIndex >= text.length) break;
      rows.push([]);
    }
  }
  return rows;
}

export async function saveCsv(name, file) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([await csvOf(name)], { type: "text/csv" }));
  link.download = file;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

const SHOWN_ROWS = 2000;

export async function fillTable(box, name, isChosen) {
  const all = await rowsOf(name);
  const rows = all.filter(isChosen);
  const heads = Object.keys(all[0] ?? {});
  const table = document.createElement("table");
  const head = table.createTHead().insertRow();
  for (const title of heads) head.append(Object.assign(document.createElement("th"), { textContent: title, scope: "col" }));
  const body = table.createTBody();
  for (const row of rows.slice(0, SHOWN_ROWS)) {
    const line = body.insertRow();
    for (const title of heads) {
      const cell = line.insertCell();
      cell.textContent = row[title] ?? "-";
      if (typeof row[title] === "number") cell.className = "number";
    }
  }
  box.replaceChildren(table);
  if (rows.length > SHOWN_ROWS) box.append(`${rows.length - SHOWN_ROWS} more rows are in the file.`);
}
