// Opens a page of results in a headless browser and tells as JSON what it found there. Arguments: node_modules, the browser,
// the page, a folder for screenshots.
import { createRequire } from "node:module";

const [modules, browserPath, file, folder] = process.argv.slice(2);
const { chromium } = createRequire(`${modules}/`)("playwright-core");
const SOFTWARE = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];
const browser = await chromium.launch({ executablePath: browserPath, args: SOFTWARE });
const found = { errors: [] };
const PATIENCE_MS = 180000; // every pixel is drawn by a core that other tests want, too

async function open(options) {
  const page = await browser.newPage(options);
  page.setDefaultTimeout(PATIENCE_MS);
  page.on("console", (message) => { if (message.type() === "error") found.errors.push(message.text()); });
  page.on("pageerror", (error) => found.errors.push(String(error)));
  page.on("request", (request) => { if (!request.url().startsWith("file:") && !/^(blob|data):/.test(request.url())) found.errors.push(request.url()); });
  await page.goto(`file://${file}`);
  return page;
}

async function drawn(page, selector) {
  await page.locator(selector).scrollIntoViewIfNeeded();
  await page.locator(`${selector}[data-drawn]`).waitFor({ timeout: PATIENCE_MS });
}

const page = await open({ viewport: { width: 1200, height: 900 }, acceptDownloads: true });
const view = "#paper-view", chart = "#paper-fig_7_collision_time";

// The slider moves the muscle, in the data and on the screen.
await drawn(page, view);
const moment = async (at) => {
  await page.locator(`${view} .slider`).evaluate((slider, value) => { slider.value = value; slider.dispatchEvent(new Event("input")); }, String(at));
  await page.waitForTimeout(200);
  const lowest = await page.locator(view).evaluate((figure) => {
    const { array } = figure.view.stage.cells[0].muscle.geometry.attributes.position;
    return Math.min(...array.filter((_, i) => i % 3 === 2));
  });
  return { lowest, words: await page.locator(`${view} .frame`).textContent(), picture: (await page.locator(`${view} .cells`).screenshot()).toString("base64") };
};
found.start = await moment(0);
found.middle = await moment(2);

// Colours of either depth.
found.deepest = {};
for (const kind of ["surface", "bone_pressure", "node"]) {
  await page.locator(`${view} .coloured`).selectOption(kind);
  found.deepest[kind] = { words: await page.locator(`${view} .cell-depth`).allTextContents(), picture: (await page.locator(`${view} .cells`).screenshot()).toString("base64") };
}

// A click on the middle of a muscle marks the node that lies there.
const cell = await page.locator(`${view} .cell`).nth(1).boundingBox();
const spot = await page.locator(view).evaluate((figure) => {
  const { stage } = figure.view, one = stage.cells[1], { position } = one.muscle.geometry.attributes, inner = one.element.getBoundingClientRect();
  stage.aim(inner.width / inner.height);
  stage.seeBones(true, false);
  for (let node = 0; node < position.count; node += 7) {
    const point = stage.camera.position.clone().fromBufferAttribute(position, node).project(stage.camera);
    const event = { clientX: inner.left + (point.x + 1) / 2 * inner.width, clientY: inner.top + (1 - point.y) / 2 * inner.height };
    if (stage.pick(event)?.node === node) return { x: event.clientX, y: event.clientY, node: figure.view.data.order[node] };
  }
  return null;
});
found.spot = spot;
await page.mouse.click(spot.x, spot.y);
found.clicked = Number(await page.locator(`${view} .node`).inputValue());
found.readout = await page.locator(`${view} .readout`).innerText();
found.cellWidth = cell.width;

// From the keyboard.
const eye = () => page.locator(view).evaluate((figure) => figure.view.stage.camera.position.toArray());
const before = await eye();
await page.locator(`${view} .cells`).focus();
await page.keyboard.press("ArrowRight");
found.turned = (await eye()).some((value, i) => Math.abs(value - before[i]) > 1e-4);

// Hovering tells what the file holds.
await drawn(page, chart);
const at = await page.locator(chart).evaluate((figure) => {
  const box = figure.querySelector(".chart").getBoundingClientRect();
  const [x, y] = figure.chart.convertToPixel({ gridIndex: 0 }, [7, 3]);
  return { x: box.left + x, y: box.top + y };
});
await page.mouse.move(at.x - 5, at.y - 5);
await page.mouse.move(at.x, at.y);
await page.waitForTimeout(300);
found.tip = await page.locator(`${chart} .chart > div`).last().innerText();
const saved = page.waitForEvent("download");
await page.locator(`${chart} .save-rows`).click();
const stream = await (await saved).createReadStream();
found.file = "";
for await (const part of stream) found.file += part;

// The Pareto picture tells of the point under the mouse, one muscle at a time; so do the bars of effects.
const pareto = "#accuracy-pareto_replay", bars = "#effects-effect_costs_chart", nights = "#history-nights";
const hover = async (id, pick) => {
  await drawn(page, id);
  const spot = await page.locator(id).evaluate((figure, [name, at]) => {
    const series = figure.chart.getOption().series.find((one) => one.type === name && one.data.length > at);
    const box = figure.querySelector(".chart").getBoundingClientRect(), { value } = series.data[at];
    const [x, y] = figure.chart.convertToPixel({ gridIndex: 0 }, name === "bar" ? [value / 2, at] : value);
    return { x: box.left + x, y: box.top + y };
  }, pick);
  await page.mouse.move(spot.x - 30, spot.y - 30);
  await page.mouse.move(spot.x, spot.y);
  await page.waitForTimeout(300);
  return page.locator(`${id} .chart > div`).last().innerText();
};
found.point = await hover(pareto, ["scatter", 1]);
await page.locator("#accuracy .choose-muscle").selectOption({ index: 1 });
found.pointOfOther = await hover(pareto, ["scatter", 1]);
found.bar = await hover(bars, ["bar", 1]);

// The history shows where it changed, and another figure where one is chosen.
const marks = () => page.locator(nights).evaluate((figure) => [...figure.querySelectorAll(".chart text")].map((one) => one.textContent).filter((text) => text.startsWith("×")));
const words = () => page.locator(`${nights} .chosen`).textContent();
await drawn(page, nights);
const step = await page.locator(nights).evaluate((figure) => {
  const dots = figure.chart.getOption().series.find((one) => one.name === "nights"), box = figure.querySelector(".chart").getBoundingClientRect();
  const [x, y] = figure.chart.convertToPixel({ gridIndex: 0 }, dots.data.find((one) => one.row.changed).value);
  return { x: box.left + x, y: box.top + y };
});
await page.mouse.move(step.x - 30, step.y - 30);
await page.mouse.move(step.x, step.y);
await page.waitForTimeout(300);
const chosen = (column) => page.locator(`${nights} .choose-rows[data-column=${column}]`);
found.history = { tip: await page.locator(`${nights} .chart .tip`).innerText(), words: await words(), marks: await marks(),
  shown: [await chosen("case").inputValue(), await chosen("metric").inputValue()] };
await page.locator(`${nights} .chart`).focus();
await page.keyboard.press("Home");
for (let night = 1; night < 9; ++night) await page.keyboard.press("ArrowRight");
found.history.heard = await page.locator(`${nights} .heard`).textContent();
await chosen("case").selectOption({ index: 0 });
await chosen("metric").selectOption("structure_bytes");
await page.locator(`${nights} summary`).click();
await page.locator(`${nights} .behind-rows tbody tr`).first().waitFor({ timeout: PATIENCE_MS });
Object.assign(found.history, { otherWords: await words(), otherMarks: await marks(), rowsBehind: await page.locator(`${nights} .behind-rows tbody tr`).count(),
  otherAxis: await page.locator(nights).evaluate((figure) => figure.chart.getOption().yAxis[0].name) });

// A backend is clicked away, in charts and views; another muscle comes.
const names = () => page.locator(chart).evaluate((figure) => [...new Set(figure.chart.getOption().series.map((one) => one.name))]);
found.shown = await names();
await page.locator(`#paper .choose-backend[value="${found.shown[0]}"]`).click();
found.without = await names();
found.cells = await page.locator(`${view} .cell`).count();
await page.locator("#paper .choose-muscle").selectOption({ index: 1 });
await page.locator(`${view}[data-drawn="${await page.locator("#paper .choose-muscle").inputValue()}"]`).waitFor({ timeout: PATIENCE_MS });
found.muscle = await page.locator(view).evaluate((figure) => figure.view.data.told.muscle);

// Arrow keys say what the mouse shows.
await page.locator(`${chart} .chart`).focus();
await page.keyboard.press("Home");
found.heard = await page.locator(`${chart} .heard`).textContent();
await page.locator(`${chart} .zoom-in`).click();
found.zoomed = await page.locator(chart).evaluate((figure) => figure.chart.getOption().dataZoom[0].end);
await page.locator(`${chart} summary`).click();
await page.locator(`${chart} .behind-rows tbody tr`).first().waitFor({ timeout: PATIENCE_MS });
found.rowsBehind = await page.locator(`${chart} .behind-rows tbody tr`).count();
// What a word means, without a mouse; all series off; the other names are behind a filter.
await page.locator("#paper .choose-backend").first().focus();
found.help = await page.locator(".help-tip").innerText();
const toggleAll = () => page.locator("#paper").evaluate((section) => section.querySelectorAll(".choose-backend").forEach((button) => button.click()));
await page.locator("#paper .choose-backend[aria-pressed=false]").click();
await toggleAll();
found.nothing = await page.locator(`${chart} .nothing`).innerText();
await toggleAll();

// Printed, all charts are there at the paper's width, and a still of the view.
await page.waitForFunction(() => document.documentElement.dataset.whole, null, { timeout: PATIENCE_MS });
await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
found.printed = await page.evaluate(() => ({
  blank: [...document.querySelectorAll("figure.has-chart:not([data-drawn])")].map((one) => one.id),
  widths: [...document.querySelectorAll("figure.has-chart")].map((one) => one.chart.getWidth()),
}));
found.printed.stills = await page.evaluate(() => Promise.all([...document.querySelectorAll(".still")].map(async (still) => {
  await still.decode();
  const paper = new OffscreenCanvas(still.naturalWidth, still.naturalHeight).getContext("2d");
  paper.drawImage(still, 0, 0);
  const { data } = paper.getImageData(0, 0, still.naturalWidth, still.naturalHeight);
  return data.filter((value, i) => i % 4 === 3 && value > 0).length / (data.length / 4);
})));
await page.evaluate(() => dispatchEvent(new Event("afterprint")));
found.printed.after = await page.locator(".still").count();
found.depth = await page.locator("#paper-depth_by_frame").evaluate((figure) => {
  const { yAxis, series } = figure.chart.getOption();
  return { type: yAxis[0].type, least: Math.min(...series.flatMap((one) => one.data.map((point) => point.value[1]))) };
});
await page.pdf({ path: `${folder}/printed.pdf` });
await page.screenshot({ path: `${folder}/light.png`, fullPage: true });
await page.close();

// A phone, and a dark screen.
for (const [name, options] of Object.entries({ phone: { viewport: { width: 360, height: 740 } }, dark: { viewport: { width: 1200, height: 900 }, colorScheme: "dark" } })) {
  const other = await open(options);
  for (const id of [view, chart, pareto, bars, nights]) await drawn(other, id);
  found[name] = await other.evaluate(() => ({ sideways: document.documentElement.scrollWidth - innerWidth, page: getComputedStyle(document.body).backgroundColor }));
  await other.screenshot({ path: `${folder}/${name}.png`, fullPage: true });
  await other.close();
}
await browser.close();
console.log(JSON.stringify(found));
