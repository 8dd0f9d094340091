"use strict";

// Objects with their grasps, and controls that select grasps by their quality.
(() => {

{% include "scene3d.js" %}

const RAMPS = {
  "red to green": [[0.78, 0.11, 0.13], [0.96, 0.73, 0.20], [0.05, 0.56, 0.25]],
  "blue to yellow (color-blind safe)": [[0.0, 0.14, 0.42], [0.47, 0.46, 0.47], [1.0, 0.90, 0.20]],
};

const COLLIDING = [0.54, 0.35, 0.66]; // violet, as in the gallery; in no ramp

function ramp(name, share) {
  const stops = RAMPS[name];
  const place = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const low = Math.min(Math.floor(place), stops.length - 2);
  return stops[low].map((value, k) => value + (stops[low + 1][k] - value) * (place - low));
}

// ---- the controls

function chosen(object, wanted) {
  const values = object.metrics[wanted.metric];
  const passing = Array.from(values.keys()).filter((grasp) =>
    values[grasp] >= wanted.least
    && (wanted.collision === "all" || (wanted.collision === "free") === Boolean(object.free[grasp])));
  const best = passing.sort((a, b) => values[b] - values[a] || a - b);
  return { passing: best.length, shown: best.slice(0, wanted.most) };
}

function start(root) {
  const data = JSON.parse(root.querySelector("script").textContent);
  const part = (name) => root.querySelector(`[name="${name}"], .${name}`);
  const canvas = root.querySelector("canvas");
  const paint = painter(canvas);
  if (!paint || !("DecompressionStream" in window)) {
    part("status").textContent = "This browser cannot show the 3D view. It needs WebGL and DecompressionStream.";
    return;
  }
  const view = { ...START };
  let object = null, asked = false;

  function redraw() {
    if (asked || !object) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; paint.draw(object, view); });
  }

  function update() {
    if (!object) return;
    const metric = Number(part("metric").value), top = data.metrics[metric][2];
    const least = top * Number(part("least").value) / 100;
    const collision = root.querySelector(".collision :checked").value;
    const wanted = { metric, least, collision, most: Number(part("most").value) || Infinity };
    const { passing, shown } = chosen(object, wanted);
    const rows = [];
    for (const grasp of shown) {
      const color = ramp(part("colors").value, object.metrics[metric][grasp] / top);
      addJaws(rows, object, grasp, object.free[grasp] ? color : COLLIDING);
    }
    paint.layer("jaws", new Float32Array(rows));
    part("status").textContent = `${shown.length} of ${passing} matching grasps shown (${object.grasps} in total)`;
    part("limit").textContent = (1000 * least).toFixed(2);
    part("top").textContent = `\u2265 ${(1000 * top).toFixed(2)}`;
    const stops = RAMPS[part("colors").value].map((stop) => `rgb(${stop.map((v) => Math.round(255 * v))})`);
    part("bar").style.background = `linear-gradient(to right, ${stops})`;
    redraw();
  }

  async function show(index) {
    const found = await unpack(data.objects[index], data.finger);
    if (index !== Number(part("object").value)) return; // another object was selected meanwhile
    object = found;
    const alone = data.objects[index].painted || data.objects.every((item) => item.counts[2] === 0);
    for (const element of root.querySelectorAll(".status, .of-grasps")) element.hidden = alone;
    const free = object.free.reduce((sum, value) => sum + value, 0);
    part("about").textContent = `${object.title}${object.title ? ": " : ""}`
      + `${object.sides.map((side) => side.toFixed(0)).join(" × ")} mm`
      + (object.grasps ? `, ${free} of ${object.grasps} grasps collision-free` : "");
    part("note").textContent = object.note;
    paint.layer("mesh", surface(object));
    update();
  }

  data.objects.forEach((item, index) => part("object").append(new Option(item.name, index)));
  data.metrics.forEach(([, name], index) => part("metric").append(new Option(name, index)));
  Object.keys(RAMPS).forEach((name) => part("colors").append(new Option(name)));
  root.querySelector(".choice").hidden = data.objects.length === 1;
  part("object").addEventListener("change", () => show(Number(part("object").value)));
  part("controls").addEventListener("input", (event) => { if (event.target.name !== "object") update(); });
  for (const [name, step] of [["before", -1], ["after", 1]]) {
    part(name).addEventListener("click", () => {
      const count = data.objects.length;
      part("object").value = (Number(part("object").value) + step + count) % count;
      show(Number(part("object").value));
    });
  }
  for (const place of document.querySelectorAll(`[data-viewer="${root.id}"]`)) {
    place.addEventListener("click", () => {
      const index = data.objects.findIndex((item) => item.name === place.dataset.object);
      if (index < 0) return;
      part("object").value = index;
      show(index);
      root.scrollIntoView({ block: "nearest" });
    });
  }
  steer(canvas, view, redraw);
  new ResizeObserver(redraw).observe(canvas);
  window.egadReady = show(0);
}

document.querySelectorAll(".viewer").forEach(start);

})();
