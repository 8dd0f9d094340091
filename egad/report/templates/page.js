"use strict";

document.documentElement.classList.add("js");

function make(name, text, className) {
  const element = document.createElement(name);
  if (text) element.textContent = text;
  if (className) element.className = className;
  return element;
}

function fixed(value, digits) {
  return value === null ? "unknown" : value.toFixed(digits);
}

function objectCard([label, id, complexity, graspability, error, certain, diversity], picture, data) {
  const card = make("div", "", picture ? "object" : "object plain");
  if (picture) {
    const image = make("img");
    image.src = picture;
    image.alt = label;
    card.append(image);
  }
  const facts = make("dl");
  facts.append(make("b", label));
  for (const line of [
    data.across + " " + fixed(complexity, 2) + data.unit,
    data.upwards + " " + fixed(graspability, 5) + (error === null ? "" : " ± " + fixed(error, 5)),
    certain === null ? "" : "in this cell with " + fixed(100 * certain, 0) + " % probability",
    "diversity " + fixed(diversity, 3),
  ]) if (line) facts.append(make("div", line));
  facts.append(make("div", id, "id"));
  card.append(facts);
  return card;
}

function startMap(figure) {
  const data = JSON.parse(figure.querySelector("script").textContent);
  const panel = figure.querySelector("aside");
  const drawing = figure.querySelector("svg");
  const cells = new Map();
  for (const cell of figure.querySelectorAll(".cell")) cells.set(cell.dataset.cell, cell);
  let shown = null;
  let selected = false;

  function show(name) {
    if (!cells.has(name)) return;
    if (shown) cells.get(shown).classList.remove("shown", "selected");
    shown = name;
    const cell = cells.get(name);
    cell.classList.add(selected ? "selected" : "shown");
    const drawn = cell.querySelector("image");
    const { items, more } = data.cells[name];
    panel.replaceChildren(make("h4", "Cell " + name));
    items.forEach((item, rank) => {
      const stored = item[7] && "data:image/png;base64," + item[7];
      panel.append(objectCard(item, rank === 0 && drawn ? drawn.getAttribute("href") : stored, data));
    });
    if (more) panel.append(make("p", "and " + more + " more", "soft"));
  }

  function walk(name, across, up) {
    let row = name.charCodeAt(0) - 65;
    let column = Number(name.slice(1));
    for (let step = 0; step < data.size; step++) {
      row += up;
      column += across;
      const next = String.fromCharCode(65 + row) + String(column).padStart(2, "0");
      if (cells.has(next)) return next;
    }
    return name;
  }

  const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  drawing.addEventListener("keydown", (event) => {
    if (!(event.key in moves) || !shown) return;
    event.preventDefault();
    show(walk(shown, ...moves[event.key]));
  });
  for (const [name, cell] of cells) {
    cell.addEventListener("mouseenter", () => { if (!selected) show(name); });
    cell.addEventListener("click", () => {
      selected = !(selected && shown === name);
      show(name);
    });
  }
  show(data.first);
}

document.querySelectorAll(".map").forEach(startMap);
window.addEventListener("beforeprint", () => {
  document.querySelectorAll("details:not(.settings)").forEach((list) => { list.open = true; });
});
