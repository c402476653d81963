"use strict";
// Headings of sortable tables become buttons; the page is complete without this.
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, at) => {
    if (!head.dataset.sort) return;
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const numeric = head.dataset.sort === "number";
      const was = head.getAttribute("aria-sort");
      const first = head.dataset.first || (numeric ? "descending" : "ascending");
      const next = was ? (was === "ascending" ? "descending" : "ascending") : first;
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", next);
      table.classList.add("sorted");
      sort(table.tBodies[0], at, numeric, next === "ascending" ? 1 : -1);
    });
  });
}

function sort(body, at, numeric, sign) {
  const value = (row) => (numeric ? parseFloat(row.cells[at].dataset.v) : row.cells[at].textContent.trim());
  const compare = (a, b) => {
    const x = value(a), y = value(b);
    if (!numeric) return sign * x.localeCompare(y, undefined, { numeric: true });
    if (isNaN(x) || isNaN(y)) return isNaN(x) - isNaN(y); // rows without a figure stay last
    return sign * (x - y);
  };
  body.append(...[...body.rows].sort(compare));
}

// A link to a record opens what hides it.
function reveal() {
  const target = location.hash.length > 1 && document.getElementById(location.hash.slice(1));
  if (!target) return;
  for (let node = target; node; node = node.parentElement) if (node.tagName === "DETAILS") node.open = true;
  target.scrollIntoView();
}
addEventListener("hashchange", reveal);
reveal();

// A score or a point of a plot opens its record on the spot; without this the link leads to the list below.
const view = document.getElementById("record-view");
document.addEventListener("click", (event) => {
  const link = event.target.closest('a[href^="#r-"]');
  if (!link || event.ctrlKey || event.metaKey || event.shiftKey || view.contains(link)) return;
  const record = document.getElementById(link.getAttribute("href").slice(1));
  if (!record || !view.showModal) return;
  event.preventDefault();
  const [summary, ...rest] = record.children;
  view.querySelector("h2").textContent = summary.querySelector(".name").textContent;
  const standing = [...summary.children].slice(1).map((part) => part.cloneNode(true));
  const outcome = document.createElement("p");
  standing.forEach((part) => outcome.append(part, " "));
  view.querySelector(".body").replaceChildren(outcome, ...rest.map((part) => part.cloneNode(true)));
  view.showModal();
});
view.addEventListener("click", (event) => {
  if (event.target === view || event.target.closest(".bar button, a[href^='#']")) view.close();
});
