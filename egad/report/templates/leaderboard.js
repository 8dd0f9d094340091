"use strict";

function fill(list, names) {
  list.replaceChildren(...names.map((name, number) => new Option(name, number)));
}

function start(box) {
  const choices = JSON.parse(box.querySelector("script").textContent);
  const [which, number] = box.querySelectorAll("select");
  const line = box.querySelector("input");
  const button = box.querySelector("button");

  function show() {
    const [, before, after] = choices[which.selectedIndex];
    const words = ["egad trials", before, number.value, after, box.dataset.rest];
    line.value = words.filter((word) => word !== "").join(" ");
    button.textContent = "Copy";
  }

  function choose() {
    fill(number, choices[which.selectedIndex][3].map((what, index) => index + ": " + what));
    show();
  }

  async function copy() {
    line.select();
    try {
      await navigator.clipboard.writeText(line.value);
    } catch {
      document.execCommand("copy"); // a page from a disk has no clipboard in some browsers
    }
    button.textContent = "Copied";
  }

  which.addEventListener("change", choose);
  number.addEventListener("change", show);
  button.addEventListener("click", copy);
  line.addEventListener("focus", () => line.select());
  box.querySelector(".choose").hidden = button.hidden = false;
  choose();
}

for (const box of document.querySelectorAll(".replay")) start(box);
