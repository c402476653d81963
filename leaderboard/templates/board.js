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
      const next = was ? (was === "ascending" ? "descending" : "ascending") : numeric ? "descending" : "ascending";
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
