for (const head of document.querySelectorAll("th")) {
  head.tabIndex = 0;
  head.title = "Sort by this column";
  const sort = () => {
    const body = head.closest("table").tBodies[0], column = head.cellIndex;
    const up = head.dataset.sorted !== "up";
    for (const other of head.parentElement.children) delete other.dataset.sorted;
    head.dataset.sorted = up ? "up" : "down";
    const value = (row) => row.cells[column].dataset.value ?? row.cells[column].textContent;
    const silent = (row) => value(row) === "–";
    const order = (a, b) => {
      const [x, y] = [value(a), value(b)], [n, m] = [Number(x), Number(y)];
      return Number.isNaN(n) || Number.isNaN(m) ? x.localeCompare(y) : n - m;
    };
    const compare = (a, b) => silent(a) - silent(b) || (up ? order(a, b) : order(b, a));
    body.append(...[...body.rows].sort(compare));
  };
  head.addEventListener("click", sort);
  head.addEventListener("keydown", (event) => { if (event.key === "Enter") sort(); });
}
