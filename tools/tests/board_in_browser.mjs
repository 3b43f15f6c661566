// Opens a board in a headless browser and tells as JSON what it found there. Arguments: node_modules, the browser, the folder of
// the board, a folder for screenshots, the page of a scene with shapes.
import { createRequire } from "node:module";

const [modules, browserPath, board, folder, scene] = process.argv.slice(2);
const { chromium } = createRequire(`${modules}/`)("playwright-core");
const SOFTWARE = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];
const browser = await chromium.launch({ executablePath: browserPath, args: SOFTWARE });
const found = { errors: [] };

async function open(path, options = {}) {
  const page = await browser.newPage({ viewport: { width: 1200, height: 900 }, ...options });
  page.setDefaultTimeout(180000);
  page.on("console", (message) => { if (message.type() === "error") found.errors.push(message.text()); });
  page.on("pageerror", (error) => found.errors.push(String(error)));
  page.on("request", (request) => { if (!/^(file|blob|data):/.test(request.url())) found.errors.push(request.url()); });
  await page.goto(`file://${board}/${path}`);
  return page;
}

const ready = (page) => page.locator("#pareto[data-drawn]").waitFor();
const told = async (page) => ({
  words: await page.locator(".board-told").textContent(), address: new URL(page.url()).hash,
  ranking: await page.locator(".board-ranking tr").evaluateAll((lines) => lines.map((line) => [...line.cells].map((cell) => cell.innerText))),
  cut: await page.locator("#pareto").evaluate((figure) => figure.chart.getOption().series.flatMap((one) => one.markLine?.data ?? []).map((line) => line.yAxis)),
  drawn: await page.locator("#pareto").evaluate((figure) => figure.chart.getOption().series.filter((one) => one.type === "scatter").reduce((sum, one) => sum + one.data.length, 0)),
});

const page = await open("index.html");
await ready(page);
found.first = await told(page);
await page.locator(".board-scenes tbody tr").first().waitFor();
found.scenes = await page.locator(".board-scenes tr").evaluateAll((lines) => lines.map((line) => [...line.cells].map((cell) => cell.innerText)));
found.crossed = await page.locator("#pareto").evaluate((figure) => figure.chart.getOption().series.flatMap((one) => (one.type === "scatter" ? one.data : []))
  .filter((point) => String(point.symbol).startsWith("path")).map((point) => point.row.why_not));
const paint = await page.evaluate(() => performance.getEntriesByType("paint").map((entry) => [entry.name, entry.startTime]));
found.paint_ms = Object.fromEntries(paint);

// The slider from the keyboard, then a number.
await page.locator(".board-at").focus();
for (let i = 0; i < 40; ++i) await page.keyboard.press("ArrowRight");
found.coarse = await told(page);
await page.locator(".board-at-number").fill("1e-5");
await page.locator(".board-at-number").press("Enter");
found.fine = await told(page);

// Another error, and a backend that is switched off; a new window at the same address shows the same.
await page.locator(".board-error").selectOption("arm");
await page.locator(".choose-backend").first().click();
found.arm = await told(page);
const again = await open(`index.html${found.arm.address}`);
await ready(again);
found.again = await told(again);
await page.screenshot({ path: `${folder}/board.png`, fullPage: true });

await again.evaluate(() => { location.hash = "error=torque&off=fcl,vtk"; });
await again.waitForTimeout(300);
found.followed = { ...(await told(again)), off: await again.locator('.choose-backend[aria-pressed="false"]').evaluateAll((buttons) => buttons.map((one) => one.value)) };

// What an address may hold.
const strange = await open("index.html#error=constructor&scene=<b>&at=-3&machine=x&off=__proto__,<i>&contacts=1");
await ready(strange);
found.strange = await told(strange);

// On a telephone, in the dark, on paper.
const phone = await open("index.html", { viewport: { width: 390, height: 800 }, colorScheme: "dark" });
await ready(phone);
found.phone = await phone.evaluate(() => ({ wide: document.documentElement.scrollWidth, shown: innerWidth, page: getComputedStyle(document.body).backgroundColor }));
await phone.screenshot({ path: `${folder}/board_phone.png`, fullPage: true });
await page.emulateMedia({ media: "print" });
found.printed = await page.locator(".board-where").innerText();
await page.pdf({ path: `${folder}/board.pdf` });

// Everything that can be used has a name.
found.nameless = await page.evaluate(() => [...document.querySelectorAll("input, select, button, a, [role=img]")]
  .filter((one) => !(one.labels?.length || one.getAttribute("aria-label") || one.getAttribute("aria-labelledby") || one.textContent.trim()))
  .map((one) => one.outerHTML.slice(0, 80)));

// Runs in space.
const shapes = await open(scene);
await shapes.locator("figure.has-view[data-drawn]").waitFor();
await shapes.locator(".cells").focus();
await shapes.keyboard.press("ArrowRight");
await shapes.waitForTimeout(500);
const sight = (one) => one.locator("figure.has-view").evaluate((figure) => figure.view.stage.sight);
found.shapes = { address: new URL(shapes.url()).hash, sight: await sight(shapes), cells: await shapes.locator(".cell").count() };
const beside = await open(`${scene}${found.shapes.address}`);
await beside.locator("figure.has-view[data-drawn]").waitFor();
await beside.waitForTimeout(300);
found.beside = { sight: await sight(beside) };
await shapes.screenshot({ path: `${folder}/board_shapes.png` });

await browser.close();
console.log(JSON.stringify(found));
