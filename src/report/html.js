"use strict";
document.documentElement.classList.add("js");

// Tables sort by a click on a column's title; numbers by their full value, not by their text.
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.textContent = head.textContent;
    head.replaceChildren(button);
    button.addEventListener("click", () => {
      const numeric = head.classList.contains("n");
      const first = numeric ? "descending" : "ascending";
      const second = numeric ? "ascending" : "descending";
      const order = head.getAttribute("aria-sort") === first ? second : first;
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", order);
      const sign = order === "ascending" ? 1 : -1;
      const key = (row) => row.cells[column].dataset.value ?? row.cells[column].textContent;
      const compare = numeric
        ? (a, b) => Number(key(a)) - Number(key(b))
        : (a, b) => key(a).localeCompare(key(b));
      const rows = [...table.tBodies[0].rows].sort((a, b) => sign * compare(a, b));
      table.tBodies[0].append(...rows);
    });
  });
}

// The viewer takes its pictures from the figures below it.
const viewer = document.querySelector(".viewer");
if (viewer) {
  const pictures = [...document.querySelectorAll("figure[data-view] img")];
  const get = (name) => viewer.querySelector(`[data-part="${name}"]`);
  const [a, b, zoom, sheet, rule, readout] = ["a", "b", "zoom", "sheet", "rule", "readout"].map(get);
  const [below, above] = sheet.querySelectorAll("img");
  let mode = "wipe", cut = 0.5, timer = 0, shown = true;
  const pixels = new Map();
  const data = (image) => {
    if (!pixels.has(image)) {
      const canvas = document.createElement("canvas");
      canvas.width = image.naturalWidth;
      canvas.height = image.naturalHeight;
      const context = canvas.getContext("2d");
      context.drawImage(image, 0, 0);
      pixels.set(image, context.getImageData(0, 0, canvas.width, canvas.height));
    }
    return pixels.get(image);
  };
  const draw = () => {
    const [first, second] = [pictures[a.value], pictures[b.value]];
    const scale = Number(zoom.value);
    above.src = first.src;
    below.src = second.src;
    for (const [image, source] of [[above, first], [below, second]]) {
      image.width = source.naturalWidth * scale;
      image.height = source.naturalHeight * scale;
    }
    sheet.style.width = `${first.naturalWidth * scale}px`;
    const part = mode === "wipe" ? cut : shown ? 1 : 0;
    above.style.clipPath = `inset(0 ${100 - 100 * part}% 0 0)`;
    rule.hidden = mode !== "wipe";
    rule.style.left = `${100 * cut}%`;
    for (const button of viewer.querySelectorAll("button[data-mode]")) {
      button.setAttribute("aria-pressed", String(button.dataset.mode === mode));
    }
  };
  const choose = (next) => {
    clearInterval(timer);
    mode = next;
    shown = next !== "b";
    if (next === "blink") {
      timer = setInterval(() => { shown = !shown; draw(); }, 500);
    }
    draw();
  };
  for (const button of viewer.querySelectorAll("button[data-mode]")) {
    button.addEventListener("click", () => choose(button.dataset.mode));
  }
  for (const input of [a, b, zoom]) input.addEventListener("change", draw);
  sheet.addEventListener("pointermove", (event) => {
    const box = sheet.getBoundingClientRect();
    const [first, second] = [data(pictures[a.value]), data(pictures[b.value])];
    const at = (share, size) => Math.min(size - 1, Math.max(0, Math.floor(share * size)));
    cut = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
    const x = at(cut, first.width), y = at((event.clientY - box.top) / (first.height * zoom.value), first.height);
    const colour = (source) => x < source.width && y < source.height
      ? [0, 1, 2].map((c) => String(source.data[4 * (y * source.width + x) + c]).padStart(3)).join(" ") : "-";
    readout.textContent = `pixel ${x},${y}   A ${colour(first)}   B ${colour(second)}   (8-bit sRGB)`;
    if (mode === "wipe") draw();
  });
  Promise.all(pictures.map((image) => image.decode())).then(draw, draw);
}
