"use strict";
const rows = new Map(JSON.parse(document.getElementById("rows").textContent).map((r) => [String(r.row), r]));
const picked = document.getElementById("picked");
function choose(id) {
  const row = rows.get(id);
  if (!row) return;
  document.querySelectorAll(".chosen").forEach((e) => e.classList.remove("chosen"));
  document.querySelectorAll(`circle[data-row="${CSS.escape(id)}"]`).forEach((e) => e.classList.add("chosen"));
  const set = Object.entries(row.set).map(([k, v]) => `${k} = ${v}`).join(", ") || "the unit itself";
  document.getElementById("picked-set").textContent = `Row ${id}, ${row.scene}: ${set}` + (row.refused ? ` – refused: ${row.refused}` : "");
  document.getElementById("picked-command").textContent = row.command;
  const table = document.getElementById("picked-figures");
  table.replaceChildren();
  for (const [name, value] of Object.entries(row.metrics || {})) {
    const tr = table.insertRow();
    tr.insertCell().textContent = name;
    tr.insertCell().textContent = value === null ? "equal" : typeof value === "number" ? String(Number(value.toPrecision(5))) : value;
  }
  picked.hidden = false;
}
function target(event) { const e = event.target.closest("[data-row]"); if (e) choose(e.dataset.row); }
document.addEventListener("click", target);
document.addEventListener("keydown", (event) => { if (event.key === "Enter") target(event); });
if (location.hash.startsWith("#row-")) choose(location.hash.slice(5));
