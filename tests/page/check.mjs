// Opens a report in headless Chromium: it must run without an error and without a request to a network, draw the shot, and draw
// another picture at another time. `node check.mjs CHROMIUM report.html...`; with PICTURES set, pictures and a PDF go there.

import { writeFileSync } from "node:fs";
import { basename, dirname, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "./chromium.mjs";

const WIDTH = 1100;
const READY = "document.body?.classList.contains('is-ready') === true";

/** Returns the number of different colours in the canvas, and a hash of its pixels. */
const CANVAS = `(() => {
  const canvas = document.getElementById("view-canvas");
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const context = copy.getContext("2d");
  context.drawImage(canvas, 0, 0);
  const pixels = new Uint32Array(context.getImageData(0, 0, copy.width, copy.height).data.buffer);
  let hash = 0;
  for (const pixel of pixels) hash = (Math.imul(hash, 31) + pixel) | 0;
  return { colours: new Set(pixels).size, hash };
})()`;

function set(id, value) {
  return `(() => { const control = document.getElementById("${id}"); control.${value};
    control.dispatchEvent(new Event("input")); })()`;
}

function require(condition, claim) {
  if (!condition) {
    throw new Error(`found otherwise: ${claim}`);
  }
}

async function open(browser, page) {
  await browser.send("Emulation.setDeviceMetricsOverride", { width: WIDTH, height: 900, deviceScaleFactor: 1, mobile: false });
  await browser.send("Page.navigate", { url: pathToFileURL(resolve(page)).href });
  await browser.until(READY);
}

async function checkView(browser) {
  const first = await browser.evaluate(CANVAS);
  require(first.colours > 20, `the view is not blank (${first.colours} colours)`);
  await browser.evaluate(set("view-time", "value = 0"));
  const start = await browser.evaluate(CANVAS);
  await browser.evaluate(set("view-time", "value = document.getElementById('view-time').max"));
  const end = await browser.evaluate(CANVAS);
  require(start.hash !== end.hash, "another time is another picture");
  await browser.evaluate(set("view-half", "checked = false"));
  const whole = await browser.evaluate(CANVAS);
  const isPlanar = await browser.evaluate("document.querySelector('.view-cuts').hidden");
  require(isPlanar || whole.hash !== end.hash, "the whole gel is another picture than the half");
  await browser.evaluate(set("view-half", "checked = true"));
  const fields = await browser.evaluate("document.getElementById('view-field').options.length");
  for (let field = fields - 1; field >= 0; field -= 1) {
    await browser.evaluate(set("view-field", `value = ${field}`));
    const ticks = await browser.evaluate("document.querySelector('.view-bar').hidden ? '' : document.querySelector('.view-bar .ticks').textContent");
    require(!/NaN|Infinity|undefined/.test(ticks), `the colour bar of field ${field} has numbers: ${ticks}`);
    require((ticks === "") === (field === 0), "gel as it looks has no colour bar, and every field has one");
  }
  await browser.evaluate("document.getElementById('view-canvas').dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft' }))");
  require((await browser.evaluate(CANVAS)).hash !== end.hash, "an arrow key moves through time");
}

async function checkPlots(browser) {
  const [plots, live] = await browser.evaluate("['', '.is-live'].map((kind) => document.querySelectorAll('figure.plot' + kind).length)");
  require(plots > 0 && plots === live, `all plots are live (${live} of ${plots})`);
}

/** Presses a button of each kind, and returns type and size of the file that it saves. */
function saved(selector, label) {
  return `(async () => {
    const saved = new Promise((done) => {
      HTMLAnchorElement.prototype.click = async function () {
        const blob = await (await fetch(this.href)).blob();
        done({ name: this.download, type: blob.type, size: blob.size });
      };
    });
    [...document.querySelectorAll("${selector} .save button")].find((button) => button.textContent === "${label}").click();
    return await saved;
  })()`;
}

async function checkSaving(browser) {
  for (const [selector, label, type, least] of [
    ["figure.section", "Save SVG", "image/svg+xml", 1000],
    ["figure.section", "Save PNG", "image/png", 3000],
    ["figure.plot", "Save PNG", "image/png", 3000],
    ["#view", "Save picture", "image/png", 3000],
  ]) {
    const file = await browser.evaluate(saved(selector, label));
    require(file.type === type && file.size > least, `${label} of ${selector} saves a picture: ${JSON.stringify(file)}`);
  }
  const [tables, buttons] = await browser.evaluate("['', ' > .save'].map((part) => document.querySelectorAll('div.wide' + part).length)");
  require(tables > 0 && tables === buttons, `all tables can be copied (${buttons} of ${tables})`);
}

async function checkFolds(browser) {
  const open = "document.querySelectorAll('main details[open]').length";
  await browser.evaluate("window.dispatchEvent(new Event('beforeprint'))");
  const printed = await browser.evaluate(open);
  await browser.evaluate("window.dispatchEvent(new Event('afterprint'))");
  const after = await browser.evaluate(open);
  require(printed > 3 && after === 0, `folded parts are open in print alone (${printed}, then ${after})`);
}

/** Writes pictures of the page in light and dark, and as it is printed. */
async function takePictures(browser, page, folder) {
  const name = basename(dirname(resolve(page)));
  for (const scheme of ["light", "dark"]) {
    await browser.send("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: scheme }] });
    await open(browser, page);
    await browser.until("new Promise((done) => setTimeout(() => done(true), 300))");
    writeFileSync(join(folder, `${name}-${scheme}.png`), await browser.picture());
    writeFileSync(join(folder, `${name}-${scheme}-all.png`), await browser.picture(true));
  }
  writeFileSync(join(folder, `${name}.pdf`), await browser.print());
}

async function check(program, page, flags, act) {
  const browser = await Browser.start(program, flags);
  try {
    await open(browser, page);
    await act(browser);
    require(browser.errors.length === 0, `no error on the console: ${browser.errors.join("\n")}`);
    const foreign = browser.requests.filter((url) => !/^(file|data|blob|about):/.test(url));
    require(foreign.length === 0, `no request to a network: ${foreign.join(", ")}`);
  } finally {
    await browser.close();
  }
}

const [program, ...pages] = process.argv.slice(2);
for (const page of pages) {
  await check(program, page, [], async (browser) => {
    await checkView(browser);
    await checkPlots(browser);
    await checkSaving(browser);
    await checkFolds(browser);
    if (process.env.PICTURES) {
      await takePictures(browser, page, process.env.PICTURES);
    }
  });
  await check(program, page, ["--disable-3d-apis"], async (browser) => {
    const isShown = await browser.evaluate("document.querySelector('.stills .shown').offsetHeight > 0");
    require(isShown, "pictures stand for the view where WebGL is missing");
  });
  console.log(`${page}: drawn, scrubbed, no error, no request`);
}
