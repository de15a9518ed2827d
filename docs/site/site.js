// The search of the site: every word must begin a word of a section; titles and
// headings count more than text. The index is a script, since pages opened from a
// disk may not read other files. "/" goes to the search.
"use strict";

const MOST_FOUND = 30;
const input = document.querySelector(".site-bar input");
const list = document.querySelector(".site-bar .found");

function escaped(word) {
  return word.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
}

// How well an entry [place, title, heading, text] fits, 0 if a word is missing.
function score(entry, words) {
  let total = 0;
  for (const word of words) {
    let best = 0;
    if (word.begins.test(entry[1])) best = 4;
    if (word.begins.test(entry[2])) best += 8;
    if (word.whole.test(entry[2])) best += 6;
    if (word.begins.test(entry[3])) best += 1;
    if (best === 0) return 0;
    total += best;
  }
  return entry[1] === "API" ? total / 2 : total;
}

// The best entries for what is typed.
function search(text) {
  const words = text.trim().split(/\s+/).filter(Boolean).map((word) => ({
    begins: new RegExp("(^|[^\\p{L}\\p{N}])" + escaped(word), "iu"),
    whole: new RegExp("(^|[^\\p{L}\\p{N}])" + escaped(word) + "($|[^\\p{L}\\p{N}])", "iu"),
  }));
  if (words.length === 0) return [];
  return SEARCH_INDEX.map((entry) => ({entry, score: score(entry, words)}))
      .filter((found) => found.score > 0)
      .sort((a, b) => b.score - a.score)
      .slice(0, MOST_FOUND)
      .map((found) => found.entry);
}

function excerpt(entry, text) {
  const place = entry[3].toLowerCase().indexOf(text.trim().split(/\s+/)[0].toLowerCase());
  const begin = Math.max(0, place - 40);
  return (begin > 0 ? "… " : "") + entry[3].slice(begin, begin + 140);
}

function show() {
  const text = input.value;
  const found = search(text);
  list.replaceChildren(...found.map((entry) => {
    const item = document.createElement("li");
    const link = document.createElement("a");
    const more = document.createElement("span");
    link.href = SITE_ROOT + entry[0];
    link.textContent = entry[2] === entry[1] ? entry[1] : entry[1] + " › " + entry[2];
    more.textContent = excerpt(entry, text);
    link.append(more);
    item.append(link);
    return item;
  }));
  if (found.length === 0 && text.trim() !== "") {
    const item = document.createElement("li");
    item.className = "none";
    item.textContent = "Nothing has all of these words";
    list.append(item);
  }
  list.hidden = text.trim() === "";
}

input.addEventListener("input", show);
input.form.addEventListener("submit", (event) => {
  event.preventDefault();
  list.querySelector("a")?.click();
});
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") list.hidden = true;
  if (event.key === "/" && !/^(INPUT|TEXTAREA)$/.test(document.activeElement.tagName)) {
    event.preventDefault();
    input.focus();
  }
  if (event.key !== "ArrowDown" && event.key !== "ArrowUp") return;
  const stops = [input, ...list.querySelectorAll("a")];
  const at = stops.indexOf(document.activeElement);
  if (at < 0 || list.hidden) return;
  event.preventDefault();
  stops[Math.min(Math.max(at + (event.key === "ArrowDown" ? 1 : -1), 0), stops.length - 1)].focus();
});
document.addEventListener("click", (event) => {
  if (!event.target.closest(".site-bar form")) list.hidden = true;
});
// On a telephone the contents are folded.
if (window.matchMedia("(max-width: 56rem)").matches) {
  document.querySelector(".site nav > details")?.removeAttribute("open");
}
show();
