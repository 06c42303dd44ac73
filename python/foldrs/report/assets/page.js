"use strict";
// Sorting, filtering and switching of what the page holds already. Nothing is loaded.

const entries = JSON.parse(document.getElementById("entries").textContent); // column values by image number
const main = document.querySelector("main");
const gallery = document.getElementById("images");
const body = document.querySelector("#rows tbody");
const cards = [...gallery.querySelectorAll(".card")];
const rows = [...body.rows];
const [find, kind, verdict, sort, direction, size, theme, shown, none] = [
  "find", "kind", "verdict", "sort", "direction", "size", "theme", "shown", "none",
].map((id) => document.getElementById(id));

const order = { column: "", descending: false };
const words = new Intl.Collator(undefined, { numeric: true, sensitivity: "base" });

function compare(a, b) {
  const [x, y] = [entries[a.dataset.number][order.column], entries[b.dataset.number][order.column]];
  const [lacksX, lacksY] = [x === null || x === undefined, y === null || y === undefined];
  if (lacksX || lacksY) return lacksX - lacksY; // what does not apply comes last, either way round
  const sign = order.descending ? -1 : 1;
  return sign * (typeof x === "number" && typeof y === "number" ? x - y : words.compare(x, y));
}

function sortBy(column, descending) {
  Object.assign(order, { column, descending });
  const sorted = (elements) => (column ? [...elements].sort(compare) : elements);
  gallery.append(...sorted(cards));
  body.append(...sorted(rows));
  sort.value = column;
  direction.textContent = descending ? "↓" : "↑";
  direction.setAttribute("aria-pressed", descending);
  for (const heading of document.querySelectorAll("#rows th[data-column]")) {
    const chosen = heading.dataset.column === column;
    if (chosen) heading.setAttribute("aria-sort", descending ? "descending" : "ascending");
    else heading.removeAttribute("aria-sort");
  }
}

function matches(element) {
  const entry = entries[element.dataset.number];
  const text = `${entry.name} ${entry.kind ?? ""} ${entry.true_kind ?? ""}`.toLowerCase();
  return (
    text.includes(find.value.trim().toLowerCase()) &&
    (!kind.value || (entry.true_kind ?? entry.kind) === kind.value) &&
    (!verdict.value || entry.verdict === verdict.value)
  );
}

function filter() {
  for (const element of [...cards, ...rows]) element.hidden = !matches(element);
  const count = cards.filter((card) => !card.hidden).length;
  shown.value = `${count} of ${cards.length} shown`;
  none.hidden = count > 0;
}

function showLayers() {
  const off = [...document.querySelectorAll("input[name=layer]:not(:checked)")];
  main.dataset.hidden = off.map((box) => box.value).join(" ");
}

function chooseExplanation(card, rank) {
  for (const part of card.querySelectorAll("[data-rank]")) {
    part.classList.toggle("off", part.dataset.rank !== rank);
  }
  card.querySelector(".aside").classList.toggle("off", rank === "0");
}

function resize() {
  document.documentElement.style.setProperty("--card", `${size.value}px`);
}

document.querySelector("form").addEventListener("submit", (event) => event.preventDefault());
for (const control of [find, kind, verdict]) control.addEventListener("input", filter);
for (const box of document.querySelectorAll("input[name=layer]")) box.addEventListener("change", showLayers);
sort.addEventListener("change", () => sortBy(sort.value, order.descending));
direction.addEventListener("click", () => sortBy(order.column, !order.descending));
size.addEventListener("input", resize);
theme.addEventListener("change", () => (document.documentElement.dataset.theme = theme.value));
for (const button of document.querySelectorAll("#rows th button")) {
  const { column } = button.parentElement.dataset;
  button.addEventListener("click", () => sortBy(column, order.column === column && !order.descending));
}
gallery.addEventListener("change", (event) => {
  if (event.target.type === "radio") chooseExplanation(event.target.closest(".card"), event.target.value);
});

sortBy("", false);
filter();
