"use strict";

document.documentElement.classList.add("js");

const sheet = JSON.parse(document.getElementById("sheet").textContent);
const PREFIX = `egad-log/${sheet.schema}/${sheet.sheet}/`;
const FORMAT = "egad-log";
const DOUBLE_TAP = 350; // ms: a second tap within them is no second attempt
const Z = 1.959963984540054; // of 95 %
const find = (selector) => document.querySelector(selector);
const all = (selector) => [...document.querySelectorAll(selector)];

function make(name, text, className) {
  const element = document.createElement(name);
  if (text) element.textContent = text;
  if (className) element.className = className;
  return element;
}

function random(length) {
  const numbers = crypto.getRandomValues(new Uint8Array(length));
  return [...numbers].map((number) => (number % 36).toString(36)).join("");
}

// Alerts that stay: one for each cause

function alarm(cause, text) {
  let box = find(`#alert-${cause}`);
  if (!text) {
    if (box) box.remove();
    return;
  }
  if (!box) {
    box = make("div", "", "alert");
    box.id = "alert-" + cause;
    find("#alerts").append(box);
  }
  if (box.textContent !== text) box.replaceChildren(make("p", text));
}

function say(text) {
  find("#said").textContent = text;
}

// Storage: a key for each result, so that results are only ever added. What is in memory and not
// in the storage of the browser is tried again each time.

const memory = new Map();
const unstored = new Set();

function put(key, value) {
  memory.set(key, value);
  unstored.add(key);
  flush();
}

function flush() {
  try {
    localStorage.setItem(PREFIX + "test", "1");
    for (const key of unstored) {
      localStorage.setItem(PREFIX + key, memory.get(key));
      unstored.delete(key);
    }
    alarm("storage", "");
  } catch (error) {
    const stored = unstored.size < memory.size;
    alarm("storage", stored
      ? `Not stored: the browser refuses to store more (${error.name}). Save a backup now; closing the page loses the last results.`
      : `This browser stores nothing for this page (${error.name}): it is a private window, or storage is switched off. Open the page elsewhere, or save a backup after every attempt; closing the page loses all results.`);
  }
}

function load() {
  try {
    const stored = new Set();
    for (let place = 0; place < localStorage.length; place++) {
      const name = localStorage.key(place);
      const key = name.slice(PREFIX.length);
      if (!name.startsWith(PREFIX) || ["test", "tab"].includes(key)) continue;
      stored.add(key);
      if (!unstored.has(key)) memory.set(key, localStorage.getItem(name));
    }
    for (const key of memory.keys()) if (!stored.has(key)) unstored.add(key);
  } catch { /* flush says it */ }
  flush();
}

function parsed(key) {
  try {
    return JSON.parse(memory.get(key) || "null");
  } catch {
    return null;
  }
}

const session = () => memory.get("current") || "";
const about = (name = session()) => parsed(name + "/about") || {};

function sessions() {
  const names = [...memory.keys()].filter((key) => key.endsWith("/about"));
  return names.map((key) => key.slice(0, -6)).sort();
}

function results(name = session()) {
  const start = name + "/result/";
  const found = [...memory.keys()].filter((key) => key.startsWith(start)).map(parsed);
  return found.filter((each) => each && sheet.order[each.slot])
    .sort((one, other) => one.seq - other.seq || (one.time < other.time ? -1 : 1));
}

// What follows from the results

function read(name = session()) {
  const every = results(name);
  const live = every.filter((each) => !each.undone);
  const closed = new Map();
  for (const each of live) {
    if (each.valid || !each.repeat) closed.set(each.slot, [...(closed.get(each.slot) || []), each]);
  }
  return {
    every,
    live,
    closed,
    next: sheet.order.findIndex((_, slot) => !closed.has(slot)),
    conflicts: [...closed.keys()].filter((slot) => closed.get(slot).length > 1).sort((a, b) => a - b),
    revision: every.length + (every.length - live.length),
  };
}

function wilson(successes, attempts) {
  if (!attempts) return [0, 1];
  const rate = successes / attempts;
  const share = Z * Z / attempts;
  const middle = (rate + share / 2) / (1 + share);
  const half = Z / (1 + share) * Math.sqrt(rate * (1 - rate) / attempts + share / (4 * attempts));
  return [Math.max(0, middle - half), Math.min(1, middle + half)];
}

function rates({ closed }) {
  return sheet.detectors.map((_, number) => {
    const tried = [...closed].filter(([slot, found]) =>
      sheet.order[slot][2] === number && found.length === 1 && found[0].valid);
    const successes = tried.filter(([, [each]]) => each.outcome === "success").length;
    return { successes, attempts: tried.length, interval: wilson(successes, tried.length) };
  });
}

const isOpen = () => !sheet.blind || Boolean(about().ended);

function called(number) {
  const { name, shown } = sheet.detectors[number];
  return name !== shown && isOpen() ? `${shown} (${name})` : shown;
}

const words = (code) => code.replaceAll("_", " ");

function told(each) {
  const [object, , detector] = sheet.order[each.slot];
  const end = each.valid ? words(each.outcome) : "not valid";
  return `No. ${each.slot + 1}, ${sheet.objects[object].label}, ${called(detector)}: ${end}`;
}

// The page

let shown = "";
let dismissed = -1;

function render() {
  const state = read();
  const name = session();
  const mine = about();
  const view = !name ? "setup" : mine.ended ? "ended" : state.next < 0 ? "complete" : "work";
  for (const each of ["setup", "work", "complete", "ended"]) find("#" + each).hidden = each !== view;
  for (const each of all(".of-session")) each.hidden = !name;
  find('[data-do="share"]').hidden = !name || !canShare();
  find('[data-do="stop"]').hidden = Boolean(mine.ended);
  find("#results").hidden = !name;
  placeForm(view);
  renderWork(state);
  renderUndo(state, view);
  renderRates(state);
  renderFiles(state);
  renderSessions(name);
  if (view === "ended") {
    find("#key").replaceChildren(...sheet.detectors.map((each) =>
      make("li", each.shown === each.name ? each.name : `${each.shown} is ${each.name}`)));
  }
  if (shown && shown !== view) find(`#${view} h2`).focus();
  shown = view;
}

function placeForm(view) {
  const form = find("#about");
  const place = view === "setup" ? find("#setup") : find("#details");
  if (form.parentNode !== place) place.append(form);
  form.querySelector("button").textContent = view === "setup" ? "Start" : "Save the details";
  for (const each of all(".version")) each.hidden = sheet.blind && !about().ended;
}

function renderWork({ next, closed, live }) {
  find("#saved").textContent = `Saved ${closed.size} of ${sheet.order.length}`;
  find("#bar").value = closed.size;
  find("#upcoming").textContent = "";
  if (next < 0) return;
  const [object, attempt, detector] = sheet.order[next];
  const { label } = sheet.objects[object];
  find("#picture").src = find(`[data-object="${object}"]`).src;
  find("#picture").alt = "Object " + label;
  find("#label").textContent = label;
  find("#detector").textContent = sheet.detectors[detector].shown;
  find("#now .badge").classList.toggle("odd", detector % 2 === 1);
  const again = live.filter((each) => each.slot === next).length;
  find("#where").textContent = `Attempt ${attempt + 1} of ${sheet.attempts}`
    + (again ? `, repeated (${again} not valid)` : "") + `; no. ${next + 1} of ${sheet.order.length}`;
  find("#upcoming").textContent = `. Next: ${find("#now").textContent}, ${find("#where").textContent}`;
}

function renderUndo({ live }, view) {
  const last = live.at(-1);
  find("#undo").hidden = !last || view === "ended" || view === "setup";
  if (last) find("#undo").textContent = "Undo: " + told(last);
}

function renderRates(state) {
  const percent = (value) => `${Math.round(100 * value)} %`;
  find("#rates").replaceChildren(...rates(state).map(({ successes, attempts, interval }, number) => {
    const row = make("tr");
    const head = make("th", called(number));
    head.scope = "row";
    row.append(head, make("td", `${successes} of ${attempts}`));
    row.append(make("td", attempts ? percent(successes / attempts) : "–"));
    row.append(make("td", attempts ? `${Math.round(100 * interval[0])} to ${percent(interval[1])}` : "–"));
    return row;
  }));
  const numbers = state.conflicts.map((slot) => slot + 1).join(", ");
  find("#conflicts").hidden = !numbers;
  find("#conflicts").textContent = `Attempts with two results, which do not count here: no. ${numbers}.`;
}

function renderFiles({ revision, live, next }) {
  const name = session();
  const exported = Number(memory.get(name + "/exported") || 0);
  find("#unexported").hidden = !name;
  find("#unexported").textContent = exported === revision
    ? "All results are in a saved file." : "Some results are only in this browser: save a file.";
  const last = live.at(-1);
  const before = last && sheet.order[last.slot][0];
  const isNew = last && next >= 0 && before !== sheet.order[next][0];
  find("#reminder").hidden = !isNew || exported === revision || dismissed === revision;
  if (isNew) find("#finished-object").textContent = sheet.objects[before].label + " is done.";
}

function renderSessions(name) {
  find("#sessions").replaceChildren(...sessions().map((each) => {
    const option = make("option", `${each}: ${read(each).closed.size} of ${sheet.order.length}`);
    option.value = each;
    option.selected = each === name;
    return option;
  }));
}

// What people do

function stamp(now = new Date()) {
  const offset = -now.getTimezoneOffset();
  const two = (number) => String(Math.floor(Math.abs(number))).padStart(2, "0");
  const local = new Date(now.getTime() + 60000 * offset).toISOString().slice(0, 19);
  return local + (offset < 0 ? "-" : "+") + two(offset / 60) + ":" + two(offset % 60);
}

let tapped = -DOUBLE_TAP;
let undone = -DOUBLE_TAP;

function record(fields) {
  const { every, next } = read();
  const now = performance.now();
  if (next < 0 || about().ended || now - tapped < DOUBLE_TAP) return;
  tapped = now;
  const id = random(12);
  const seq = 1 + Math.max(0, ...every.map((each) => each.seq));
  const note = find("#note").value.trim();
  const { calibration = "" } = about();
  const kept = { id, seq, slot: next, time: stamp(), valid: true, ...fields, note, calibration };
  put(`${session()}/result/${id}`, JSON.stringify(kept));
  setNote("");
  say("");
  render();
}

function setNote(text) {
  find("#note").value = text;
  put(session() + "/draft", text);
}

function undo() {
  const last = read().live.at(-1);
  const now = performance.now();
  if (!last || about().ended || now - undone < DOUBLE_TAP) return;
  undone = now;
  put(`${session()}/result/${last.id}`, JSON.stringify({ ...last, undone: stamp() }));
  if (last.note && !find("#note").value) setNote(last.note);
  say("Undone: " + told(last));
  render();
}

function start() {
  const name = `${stamp().slice(0, 16).replace("T", "-").replace(":", "")}-${random(4)}`;
  put(name + "/about", JSON.stringify({ started: stamp(), ...filledIn() }));
  put("current", name);
  navigator.storage?.persist?.().catch(() => {});
}

function filledIn() {
  const data = new FormData(find("#about"));
  const fields = Object.fromEntries(sheet.fields.map((key) => [key, data.get(key).trim()]));
  const versions = sheet.detectors.map((_, number) => data.get("version-" + number).trim());
  return { ...fields, versions };
}

function fillIn() {
  const mine = session() ? about() : parsed("form") || {};
  for (const key of sheet.fields) find("#field-" + key).value = mine[key] || "";
  sheet.detectors.forEach((_, number) => {
    find("#version-" + number).value = mine.versions?.[number] || "";
  });
  find("#note").value = memory.get(session() + "/draft") || "";
}

function change(values) {
  put(session() + "/about", JSON.stringify({ ...about(), ...values }));
}

function choose(name) {
  put("form", JSON.stringify(about()));
  put("current", name);
  fillIn();
  render();
  find("main").scrollIntoView();
}

// Files

function escaped(value) {
  const text = /^\s*[=+\-@]|^[\t\r]/.test(value) ? "'" + value : String(value);
  return /[",;\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

function csv() {
  const mine = about();
  const rows = results().map((each) => {
    const [object, attempt, detector] = sheet.order[each.slot];
    const { name } = sheet.detectors[detector];
    const fields = Object.fromEntries(sheet.fields.map((key) => [key, mine[key] || ""]));
    const row = {
      ...fields,
      ...sheet.objects[object],
      schema: sheet.schema,
      session: session(),
      order: each.slot + 1,
      time: each.time,
      attempt,
      detector: name,
      version: mine.versions?.[detector] || "",
      success: each.outcome ? Number(each.outcome === "success") : "",
      outcome: each.outcome || "",
      valid: Number(each.valid && !each.undone),
      reason: each.undone ? "undone" : each.reason || "",
      note: each.note,
      calibration: each.calibration,
      blind: Number(sheet.blind),
      seed: sheet.seed,
      record: each.id,
    };
    return sheet.columns.map((column) => escaped(row[column] ?? ""));
  });
  return "\ufeff" + [sheet.columns, ...rows].map((row) => row.join(",") + "\r\n").join("");
}

function backup() {
  const kept = { format: FORMAT, schema: sheet.schema, sheet: sheet.sheet, session: session() };
  return JSON.stringify({ ...kept, about: about(), results: results() }, null, 1);
}

function file(ending, text, type) {
  return new File([text], `egad-log-${session()}.${ending}`, { type });
}

const csvFile = () => file("csv", csv(), "text/csv");

function download(content) {
  const link = make("a");
  link.href = URL.createObjectURL(content);
  link.download = content.name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  exported(content.name + " was given to the browser to save.");
}

function exported(text) {
  put(session() + "/exported", String(read().revision));
  say(text);
  render();
}

async function copy() {
  const text = csv().slice(1);
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = make("textarea", text);
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    if (!done) return say("The browser does not let this page copy. Save the file instead.");
  }
  return exported("Copied: paste it into a message or a file.");
}

function canShare() {
  return Boolean(navigator.canShare?.({ files: [new File(["x"], "x.csv", { type: "text/csv" })] }));
}

async function share() {
  try {
    await navigator.share({ files: [csvFile()] });
    exported("Shared.");
  } catch (error) {
    if (error.name !== "AbortError") say("It could not be shared: " + error.message);
  }
}

function isResult(each) {
  return each && /^[a-z0-9]{1,20}$/.test(each.id) && Number.isInteger(each.seq)
    && Number.isInteger(each.slot) && each.slot >= 0 && each.slot < sheet.order.length
    && typeof each.time === "string" && typeof each.note === "string"
    && (each.valid === true ? sheet.outcomes.includes(each.outcome) : each.valid === false);
}

function merge(text) {
  let given;
  try {
    given = JSON.parse(text);
  } catch {
    return "This file is not a backup of a grasp log.";
  }
  const name = given?.session;
  if (given?.format !== FORMAT || !/^[\w-]{1,40}$/.test(name) || !Array.isArray(given.results)) {
    return "This file is not a backup of a grasp log.";
  }
  if (given.sheet !== sheet.sheet || given.schema !== sheet.schema) {
    return `This backup is of another sheet (${String(given.sheet).slice(0, 20)}); open the page with which it was made.`;
  }
  const known = new Map(results(name).map((each) => [each.id, each]));
  const usable = given.results.filter(isResult);
  let added = 0;
  let different = 0;
  for (const each of usable) {
    const ours = known.get(each.id);
    const isOther = ours && (ours.slot !== each.slot || ours.outcome !== each.outcome || ours.valid !== each.valid);
    if (isOther) different++;
    else if (!ours) added++;
    if (!ours || (each.undone && !ours.undone && !isOther)) {
      put(`${name}/result/${each.id}`, JSON.stringify(each));
    }
  }
  put(name + "/about", JSON.stringify({ ...given.about, ...about(name) }));
  if (name !== session()) choose(name);
  const left = given.results.length - usable.length;
  return `Restored: ${added} results added, ${known.size} were already here.`
    + (different ? ` ${different} differ from those here, which are kept.` : "")
    + (left ? ` ${left} cannot be read and are left out.` : "");
}

async function restore(input) {
  const [chosen] = input.files;
  if (!chosen) return;
  const text = merge(await chosen.text());
  input.value = "";
  fillIn();
  render();
  say(text);
}

// Other tabs

const tab = random(8);

function call(word) {
  try {
    localStorage.setItem(PREFIX + "tab", `${tab} ${word} ${performance.now()}`);
  } catch { /* then there is nothing that they share */ }
}

function hear(message) {
  const [other, word] = message.split(" ");
  if (other === tab) return;
  if (word === "hello") call("here");
  alarm("tab", word === "bye" ? "" : "This page is open in another tab too. Both save into the same session: close one of them, so that no attempt is logged twice.");
}

window.addEventListener("storage", (event) => {
  if (event.key === PREFIX + "tab") return hear(event.newValue || "");
  if (event.key && !event.key.startsWith(PREFIX)) return;
  if (event.key === PREFIX + "test") return;
  const before = session();
  load();
  if (session() !== before) fillIn();
  render();
});

// Events

const actions = {
  csv: () => download(csvFile()),
  backup: () => download(file("json", backup(), "application/json")),
  copy,
  share,
  print: () => window.print(),
  later: () => { dismissed = read().revision; render(); },
  end: () => ask("End the session? Its results can then no longer be changed."),
  stop: () => ask(`End the session with ${read().closed.size} of ${sheet.order.length} attempts? It cannot be continued.`),
  new: () => choose(""),
  cancel: () => find("#why").close(),
};

function ask(question) {
  find("#question").textContent = question;
  find("#sure").returnValue = "";
  find("#sure").showModal();
}

document.addEventListener("click", (event) => {
  const { outcome, do: action } = event.target.closest("button")?.dataset || {};
  if (outcome) record({ outcome });
  if (action) actions[action]();
});
// A key that is held down presses a button again and again.
document.addEventListener("keydown", (event) => {
  if (event.repeat && event.target.closest("button")) event.preventDefault();
});
find("#undo").addEventListener("click", undo);
find("#note").addEventListener("input", (event) => put(session() + "/draft", event.target.value));
find("#restore").addEventListener("change", (event) => restore(event.target));
find("#sessions").addEventListener("change", (event) => choose(event.target.value));
find("#sure").addEventListener("close", () => {
  if (find("#sure").returnValue !== "yes") return;
  change({ ended: stamp() });
  render();
});
find("#about").addEventListener("input", () => { if (!session()) put("form", JSON.stringify(filledIn())); });
find("#about").addEventListener("submit", (event) => {
  event.preventDefault();
  if (session()) {
    change(filledIn());
    say("The details are saved.");
  } else start();
  render();
});
find("#invalid").addEventListener("click", () => {
  find("#why form").reset();
  find("#why").showModal();
});
find("#why form").addEventListener("change", ({ currentTarget }) => {
  currentTarget.elements.words.required = currentTarget.elements.reason.value === "";
});
find("#why form").addEventListener("submit", (event) => {
  const data = new FormData(event.target);
  const reason = data.get("reason") || data.get("words").trim() || "no reason given";
  record({ valid: false, repeat: event.submitter.value === "repeat", reason });
});
window.addEventListener("pagehide", () => call("bye"));
window.addEventListener("pageshow", (event) => { if (event.persisted) call("hello"); });
document.addEventListener("visibilitychange", () => {
  if (document.hidden) return;
  load();
  render();
});
window.addEventListener("beforeunload", (event) => { if (unstored.size) event.preventDefault(); });

load();
fillIn();
render();
call("hello");
