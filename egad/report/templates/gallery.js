"use strict";

// The gallery: a map of objects with filters, and a view of one object. All of its data are scripts
// beside the page that call egadData; see egad/report/gallery/files.py.
(() => {

{% include "scene3d.js" %}

const STEP = 60; // objects that are listed at a time
const SHOWN = 12; // grasps that are shown at first
const LABELS = {{ labels | tojson }};
const COLORS = ["--unknown", "--held", "--failed", "--collision"]; // of the labels
const ANCESTOR = "ancestor";
const ANCESTOR_COLUMNS = {{ ancestor_columns }}, ANCESTORS_PER_SHEET = {{ ancestors_per_sheet }};
const FOLDER = {{ folder | tojson }};
const ANCESTORS = {{ ancestors }}, MAX_FILES = {{ max_files }}; // in a folder

const find = (selector) => document.querySelector(selector);

function make(name, text = "", properties = {}) {
  const element = Object.assign(document.createElement(name), properties);
  if (text) element.textContent = text;
  return element;
}

// ---- data: scripts that are loaded when they are needed

const arrived = new Map();
window.egadData = (name, data) => arrived.set(name, data);

// Where the file of one of `count` things is; the same as file_stems in egad/exchange/release/tables.py.
const stem = (name, number, count) => count > MAX_FILES ? `${String(Math.floor(number / MAX_FILES)).padStart(2, "0")}/${name}` : name;

function load(kind, name, file = name) {
  const key = name === undefined ? kind : `${kind}/${name}`, path = name === undefined ? kind : `${kind}/${file}`;
  return new Promise((resolve, reject) => {
    const script = make("script", "", { src: `${FOLDER}/${path.split("/").map(encodeURIComponent).join("/")}.js` });
    script.onload = script.onerror = () => {
      script.remove();
      if (arrived.has(key)) resolve(arrived.get(key));
      else reject(new Error(`${decodeURIComponent(script.src)} could not be loaded.`));
      arrived.delete(key);
    };
    document.head.append(script);
  });
}

// ---- the index

let index = null, objects = [], byLabel = new Map(), byId = new Map();

function readIndex(data) {
  index = data;
  const { columns } = data;
  objects = columns.label.map((_, i) => Object.fromEntries(Object.entries(columns).map(([key, values]) => [key, values[i]])));
  for (const [i, object] of objects.entries()) {
    object.file = stem(object.label, i, objects.length);
    object.cell = cellName(object.column, object.row);
    byLabel.set(object.label, object);
    byId.set(object.id, object);
  }
}

const cellName = (column, row) => String.fromCharCode(65 + row) + String(column).padStart(2, "0");

// A number with its standard error and unit, both of which it may lack.
function quantity(value, error, unit, decimals) {
  if (value === null) return "unknown";
  if (typeof value === "string") return `${value}\u00a0${unit}`;
  let text = value.toFixed(decimals);
  if (error !== null) text += `\u00a0±\u00a0${error.toFixed(decimals)}`;
  if (error !== null && unit.startsWith("×")) text = `(${text})`;
  return unit ? `${text}\u00a0${unit}` : text;
}

// ---- pictures

function place(element, sheet, column, row, columns, rows) {
  element.style.backgroundImage = `url("${sheet}")`;
  element.style.backgroundSize = `${100 * columns}% ${100 * rows}%`;
  const at = (number, count) => (count > 1 ? 100 * number / (count - 1) : 0);
  element.style.backgroundPosition = `${at(column, columns)}% ${at(row, rows)}%`;
}

function placeObject(element, { rank, column, row }) {
  place(element, index.sheets[rank], column, index.cells - 1 - row, index.cells, index.cells);
}

function thumb(object) {
  const element = make("span", "", { className: "thumb" });
  if ("rank" in object) placeObject(element, object);
  else {
    const number = object.number % ANCESTORS_PER_SHEET, sheet = Math.floor(object.number / ANCESTORS_PER_SHEET);
    place(element, `${FOLDER}/sheets/ancestors-${sheet}.webp`, number % ANCESTOR_COLUMNS, Math.floor(number / ANCESTOR_COLUMNS),
      ANCESTOR_COLUMNS, ANCESTORS_PER_SHEET / ANCESTOR_COLUMNS);
  }
  return element;
}

// ---- what is shown: filters, which the address keeps

const filters = { text: "", cell: "", family: "", chosen: "" };
let found = [], listed = STEP;

function readFilters(parameters) {
  for (const name of Object.keys(filters)) filters[name] = parameters.get(name) ?? "";
  const form = find("#filters");
  form.text.value = filters.text;
  form.family.value = filters.family;
  form.chosen.checked = filters.chosen !== "";
  for (const input of form.querySelectorAll("[type=number]")) input.value = parameters.get(input.name) ?? "";
  if ([...parameters.keys()].some((name) => name !== "text" && name !== "cell")) find("#filters details").open = true;
}

function readForm() {
  const form = find("#filters");
  filters.text = form.text.value.trim();
  filters.family = form.family.value;
  filters.chosen = form.chosen.checked ? "1" : "";
}

function parametersOf() {
  const parameters = new URLSearchParams();
  for (const [name, value] of Object.entries(filters)) if (value) parameters.set(name, value);
  for (const input of find("#ranges").querySelectorAll("input")) if (input.value !== "") parameters.set(input.name, input.value);
  return parameters;
}

function ranges() {
  return index.measures.flatMap((measure) => ["from", "to"].map((end) => {
    const { value } = find("#filters").elements[`${measure.key}-${end}`];
    return value === "" ? null : { key: measure.key, factor: measure.factor, end, limit: Number(value) };
  })).filter(Boolean);
}

function matching(withCell) {
  const limits = ranges(), text = filters.text.toLowerCase();
  return objects.filter((object) =>
    (!withCell || !filters.cell || object.cell === filters.cell)
    && (!filters.family || object.family === filters.family)
    && (!filters.chosen || object.place)
    && (!text || object.label.toLowerCase().startsWith(text) || object.id.toLowerCase().startsWith(text) || object.place.toLowerCase() === text)
    && limits.every(({ key, factor, end, limit }) => {
      const value = object[key] === null ? NaN : factor * object[key];
      return end === "from" ? value >= limit : value <= limit;
    }));
}

function update() {
  const rest = matching(false);
  found = filters.cell ? rest.filter((object) => object.cell === filters.cell) : rest;
  listed = STEP;
  paintMap(rest);
  list();
  find("#count").textContent = `${filters.cell ? `Cell ${filters.cell}: ` : ""}${found.length} ${found.length === 1 ? "object" : "objects"}`;
  find("#clear").hidden = parametersOf().toString() === "";
}

function list() {
  find("#results").replaceChildren(...found.slice(0, listed).map(card));
  find("#more").hidden = found.length <= listed;
}

function card(object) {
  const item = make("li"), link = make("a", "", { href: addressOf(object.label) }), text = make("span");
  text.append(make("b", object.label));
  if (object.place) text.append(make("small", ` evaluation set: ${object.place}`));
  for (const { key, name, unit, factor, decimals } of index.measures.slice(0, 2)) {
    const scaled = (number) => (number === null ? null : factor * number);
    const error = key === "graspability" ? scaled(object.error) : null;
    text.append(make("small", `${name} ${quantity(scaled(object[key]), error, unit, decimals)}`));
  }
  link.append(thumb(object), text);
  item.append(link);
  return item;
}

const addressOf = (label) => `#${encodeURIComponent(label)}`;

// ---- the map

const cells = new Map();

function drawMap() {
  const map = find("#map"), count = index.cells;
  find(".frame").style.setProperty("--cells", count);
  for (let i = 0; i < count; i++) {
    find(".letters").append(make("span", String.fromCharCode(65 + count - 1 - i)));
    find(".numbers").append(make("span", String(i).padStart(2, "0")));
  }
  const filled = new Map();
  for (const object of objects) filled.set(object.cell, [...(filled.get(object.cell) ?? []), object]);
  const ordered = [...filled.values()].sort(([a], [b]) => b.row - a.row || a.column - b.column);
  for (const members of ordered) {
    const [{ cell, column, row }] = members;
    members.sort((a, b) => a.rank - b.rank);
    const button = make("button", "", { type: "button", className: "cell", tabIndex: -1 });
    button.dataset.cell = cell;
    button.style.gridArea = `${count - row} / ${column + 1}`;
    button.append(make("i"));
    cells.set(cell, { button, members, column, row });
  }
  if (index.unattainable) {
    const rows = make("div", "", { className: "unattainable" });
    rows.style.gridArea = `${count - index.unattainable + 1} / 1 / ${count + 1} / ${count + 1}`;
    map.append(rows);
  }
  map.append(...[...cells.values()].map(({ button }) => button));
  const first = cells.get(filters.cell) ?? cells.values().next().value;
  if (first) first.button.tabIndex = 0;
  map.addEventListener("click", (event) => {
    const button = event.target.closest(".cell");
    if (button) choose(button.dataset.cell);
  });
  map.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    const from = event.target.closest(".cell");
    if (!step || !from) return;
    event.preventDefault();
    const next = neighbor(cells.get(from.dataset.cell), ...step);
    if (next) focusOn(next);
  });
}

function neighbor({ column, row }, across, up) {
  for (let k = 1; k < index.cells; k++) {
    const next = cells.get(cellName(column + k * across, row + k * up));
    if (next) return next;
  }
  return null;
}

function focusOn({ button }) {
  find("#map").querySelector("[tabindex='0']").tabIndex = -1;
  button.tabIndex = 0;
  button.focus();
}

function choose(cell) {
  filters.cell = filters.cell === cell ? "" : cell;
  focusOn(cells.get(cell));
  remember();
  const list = find(".found");
  if (filters.cell && list.getBoundingClientRect().top > 0.8 * innerHeight) list.scrollIntoView({ block: "center" });
}

function paintMap(rest) {
  const kept = new Set(rest);
  for (const [name, { button, members }] of cells) {
    const inside = members.filter((object) => kept.has(object));
    placeObject(button.firstChild, inside[0] ?? members[0]);
    button.classList.toggle("out", inside.length === 0);
    button.classList.toggle("selected", name === filters.cell);
    button.ariaPressed = String(name === filters.cell);
    button.ariaLabel = button.title = `${name}: ${inside.length} ${inside.length === 1 ? "object" : "objects"}`;
  }
}

function remember() {
  history.replaceState(null, "", `#${parametersOf()}`);
  update();
}

function drawFilters() {
  const form = find("#filters");
  for (const measure of index.measures) {
    const [from, to] = rangeOf(measure);
    const field = make("fieldset");
    field.append(make("legend", measure.name + (measure.unit ? ` (${measure.unit})` : "")));
    for (const [end, limit] of Object.entries({ from, to })) {
      const input = make("input", "", { type: "number", step: "any", name: `${measure.key}-${end}` });
      input.ariaLabel = `${measure.name} ${end}`;
      input.placeholder = Number.isFinite(limit) ? `${end} ${limit.toFixed(measure.decimals)}` : end;
      field.append(input);
    }
    find("#ranges").append(field);
  }
  const counts = new Map();
  for (const { family } of objects) counts.set(family, (counts.get(family) ?? 0) + 1);
  form.family.append(new Option("all", ""));
  for (const [family, count] of [...counts].sort((a, b) => b[1] - a[1] || (a[0] < b[0] ? -1 : 1))) {
    if (family) form.family.append(new Option(`${family} (${count})`, family));
  }
  find("#families").hidden = form.family.length < 3;
  find("#chosen").hidden = !objects.some((object) => object.place);
  form.addEventListener("input", () => { readForm(); remember(); });
  form.addEventListener("submit", (event) => event.preventDefault());
  form.text.addEventListener("keydown", (event) => {
    if (event.key === "Enter" && found.length) location.hash = addressOf(found[0].label);
  });
  find("#clear").addEventListener("click", () => { readFilters(new URLSearchParams()); remember(); });
  find("#more").addEventListener("click", () => {
    listed += STEP;
    list();
    find(`#results li:nth-child(${listed - STEP + 1}) a`).focus();
  });
}

// An id is a hash; its beginning is enough to tell relatives apart.
const shortName = (id) => id.slice(0, 8);

// ---- one object

let paint = null, current = null, asked = false;
const view = { ...START };

function redraw() {
  if (asked || !current || !paint) return;
  asked = true;
  requestAnimationFrame(() => { asked = false; if (current) paint.draw(current, view); });
}

const colorOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const channels = (hex) => [...(hex.length === 4 ? hex.slice(1).replace(/./g, "$&$&") : hex.slice(1)).matchAll(/../g)].map(([pair]) => parseInt(pair, 16) / 255);

function drawGrasps() {
  const form = find("#grasps"), rows = [];
  const wanted = new Set([...form.querySelectorAll("#labels input:checked")].map((input) => Number(input.value)));
  const matching = Array.from(current.codes.keys()).filter((grasp) => wanted.has(current.codes[grasp]));
  const shown = matching.slice(0, Number(form.most.value));
  for (const grasp of shown) addJaws(rows, current, grasp, channels(colorOf(COLORS[current.codes[grasp]])));
  paint?.layer("jaws", new Float32Array(rows));
  find("#shown").textContent = `${shown.length} of ${matching.length}`;
  redraw();
}

function showGrasps(object, counts) {
  const form = find("#grasps");
  form.hidden = counts === null;
  if (counts === null) return;
  const simulated = object.labels !== null;
  object.codes = object.labels ?? object.free.map((free) => (free ? 0 : 3));
  find("#missing").textContent = simulated || !object.grasps ? "" : "These grasps were not simulated.";
  find("#labels").replaceChildren(...LABELS.map((name, code) => {
    const label = make("label"), input = make("input", "", { type: "checkbox", checked: true, value: code }), swatch = make("i");
    swatch.style.background = `var(${COLORS[code]})`;
    label.append(input, swatch, simulated || code ? name : "collision-free", make("span", String(counts[code])));
    label.hidden = counts[code] === 0;
    return label;
  }));
  form.most.max = object.grasps;
  form.most.value = Math.min(SHOWN, object.grasps);
  form.most.parentElement.hidden = object.grasps === 0;
}

async function showShape(data, address) {
  const canvas = find("#object canvas");
  find("#object .view").hidden = !data.scene;
  if (!data.scene) { current = null; find("#grasps").hidden = true; return; }
  if (!paint && "DecompressionStream" in window) {
    paint = painter(canvas, () => channels(colorOf("--faint")));
    if (paint) steer(canvas, view, redraw);
  }
  for (const part of find("#object .view").children) part.hidden = (part.id === "flat") === Boolean(paint);
  if (!paint) { find("#grasps").hidden = true; return; }
  const object = await unpack(data.scene, index.finger);
  if (asOpened() !== address) return;
  Object.assign(view, START);
  paint.layer("mesh", surface(object));
  paint.layer("jaws", new Float32Array(0));
  current = object;
  showGrasps(object, data.labels);
  if (data.labels) drawGrasps(); else redraw();
}

// The range of a measure over all objects, as it is printed.
function rangeOf({ key, factor }) {
  const values = objects.map((object) => object[key]).filter((value) => value !== null);
  const ends = values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
  return ends.map((value) => factor * value);
}

// A value with its error, within the range of all objects.
function bar(value, error, [low, high]) {
  const element = make("span", "", { className: "bar" });
  const share = (number) => 100 * Math.min(Math.max((number - low) / (high - low), 0), 1);
  const mark = make("i"), whisker = make("b");
  mark.style.left = `${share(value)}%`;
  whisker.style.left = `${share(value - error)}%`;
  whisker.style.right = `${100 - share(value + error)}%`;
  element.append(whisker, mark);
  element.ariaHidden = "true";
  return element;
}

function showMeasures(facts) {
  find("#measures tbody").replaceChildren(...facts.map(([name, value, error, unit, decimals]) => {
    const row = make("tr"), middle = make("td"), measure = index.measures.find((each) => each.name === name);
    const range = measure ? rangeOf(measure) : [0, 0];
    if (range[0] < range[1]) middle.append(bar(value, error ?? 0, range));
    row.append(make("th", name, { scope: "row" }), middle, make("td", quantity(value, error, unit, decimals)));
    return row;
  }));
}

function relative(entry) {
  const object = typeof entry === "string" ? byLabel.get(entry) : { label: shortName(entry[0]), number: entry[1] };
  const link = make("a", "", { href: typeof entry === "string" ? addressOf(entry) : `#${ANCESTOR}=${entry[1]}` });
  link.append(thumb(object), object.label);
  const item = make("li");
  item.append(link);
  return item;
}

function showLineage(relatives) {
  find("#lineage").hidden = !relatives;
  if (!relatives) return;
  for (const name of ["line", "parents", "children"]) {
    const items = relatives[name].map(relative);
    find(`#${name}`).replaceChildren(...items);
    if (name !== "line") find(`#${name}`).parentElement.hidden = items.length === 0;
  }
  const line = find("#line");
  line.classList.add("ordered");
  line.lastChild.firstChild.ariaCurrent = "page";
  line.scrollLeft = line.scrollWidth;
}

function showGenome(genome) {
  find("#genome").hidden = !genome;
  if (!genome) return;
  find("#drawing").src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(genome.drawing)}`;
  find("#expressions").textContent = genome.text;
}

function showTrials(trials) {
  find("#trials").hidden = trials.length === 0;
  const percent = (share) => `${Math.round(100 * share)}\u00a0%`;
  find("#trials tbody").replaceChildren(...trials.map(([name, successes, attempts, low, high]) => {
    const row = make("tr");
    row.append(make("th", name, { scope: "row" }));
    for (const text of [`${successes} of ${attempts}`, attempts ? percent(successes / attempts) : "–", `${percent(low)} to ${percent(high)}`]) row.append(make("td", text));
    return row;
  }));
}

function showDownloads(links) {
  find("#downloads").hidden = links.length === 0;
  find("#downloads ul").replaceChildren(...links.map(([text, href]) => {
    const item = make("li");
    item.append(make("a", text, { href }));
    return item;
  }));
}

function walkLinks(object) {
  const order = found.includes(object) ? found : objects, at = order.indexOf(object);
  for (const [name, step] of [["before", -1], ["after", 1]]) {
    const link = find(`#${name}`), next = object && order[at + step];
    link.hidden = !next;
    if (next) link.href = addressOf(next.label);
  }
  find("#back").href = `#${parametersOf()}`;
}

function about(object, id) {
  const parts = object ? [`cell ${object.cell}`] : ["ancestor, not in the released set"];
  if (object?.place) parts.push(`${object.place} of the evaluation set`);
  const line = find("#about");
  line.replaceChildren(parts.join(" · "));
  if (object?.family) {
    line.append(" · family ", make("a", object.family, { href: `#family=${encodeURIComponent(object.family)}` }));
  }
  if (object && object.label !== id) line.append(` · id ${id}`);
}

async function open(kind, name) {
  const object = kind === "objects" ? byLabel.get(name) : null;
  const address = asOpened(), data = await load(kind, name, object?.file ?? stem(name, Number(name), ANCESTORS));
  if (asOpened() !== address) return; // another one was opened meanwhile
  const title = object ? name : data.id;
  find("#name").textContent = title;
  document.title = `${title} – ${find("h1").textContent}`;
  about(object, data.id);
  find("#note").textContent = data.note;
  showMeasures(data.facts);
  walkLinks(object);
  showTrials(data.trials);
  showGenome(data.genome);
  showDownloads(data.links);
  find("#overview").hidden = true;
  find("#object").hidden = false;
  showLineage(data.relatives);
  await showShape(data, address);
  scrollTo(0, 0);
  find("#name").focus({ preventScroll: true });
}

// ---- the address decides what is shown

function asOpened() {
  const hash = location.hash.slice(1), parameters = new URLSearchParams(hash);
  if (/^\d+$/.test(parameters.get(ANCESTOR))) return `ancestors/${parameters.get(ANCESTOR)}`;
  let name = hash;
  try { name = decodeURIComponent(hash); } catch { /* a percent sign that encodes nothing */ }
  const object = byLabel.get(name) ?? byId.get(name);
  return object ? `objects/${object.label}` : "";
}

async function follow() {
  const trouble = find("#trouble"), target = asOpened();
  trouble.hidden = true;
  try {
    if (target) {
      const cut = target.indexOf("/");
      await open(target.slice(0, cut), target.slice(cut + 1));
      return;
    }
    current = null;
    find("#object").hidden = true;
    find("#overview").hidden = false;
    document.title = find("h1").textContent;
    readFilters(new URLSearchParams(location.hash.slice(1)));
    update();
  } catch (error) {
    trouble.textContent = error.message;
    trouble.hidden = false;
  }
}

async function start() {
  try {
    readIndex(await load("index"));
  } catch (error) {
    find("#trouble").textContent = error.message;
    find("#trouble").hidden = false;
    return;
  }
  drawFilters();
  drawMap();
  find("#grasps").addEventListener("input", drawGrasps);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  new ResizeObserver(redraw).observe(find("#object canvas"));
  addEventListener("hashchange", follow);
  found = objects;
  await follow();
  performance.mark("egad-ready");
}

window.egadReady = start();

})();
