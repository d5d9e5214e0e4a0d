// The report: its body is drawn at once, all else is there already. Marks of charts, by the names before the colon of what they say,
// and rows of tables, by their first cell, belong to the limbs and receptors that they name: these light up, and a limb that is
// chosen picks them out.
(() => {
  document.documentElement.classList.toggle("framed", self !== top);
  const figures = [...document.querySelectorAll("figure.body")];
  for (const { limbs, receptors, limbOf, light, pick, onLimb } of figures.map(Body)) {
    const named = [...document.querySelectorAll(".chart title, section tbody th")].map((name) => {
      const words = name.textContent.split(": ")[0].split(", ");
      const felt = words.filter((word) => word in receptors).map((word) => receptors[word]);
      return { part: name.parentElement, says: name.textContent, felt, of: [...words.flatMap((word) => limbs[word] || []), ...felt.map(limbOf)] };
    }).filter(({ of }) => of.length > 0);
    // Of a touch its receptors are shown, of all else limbs.
    const point = ({ of, felt }) => light(felt.length > 0 ? [] : of, felt);
    for (const own of named) {
      own.part.addEventListener("pointerenter", () => point(own));
      own.part.addEventListener("pointerleave", () => light([]));
      if (own.of.length > 1 || !own.part.matches("tr")) continue;
      own.part.classList.add("chooses");
      own.part.addEventListener("click", () => pick(own.of[0]));
    }
    onLimb((limb) => {
      for (const { part, of } of named) {
        part.classList.toggle("aside", limb !== null && !of.includes(limb));
        part.classList.toggle("picked", limb !== null && of.includes(limb));
      }
    });
    // The arrow keys go through the marks of a chart that has the focus; what a mark says is below the chart.
    for (const chart of document.querySelectorAll(".wide:has(.chart)")) {
      const marks = named.filter(({ part }) => chart.contains(part));
      if (marks.length === 0) continue;
      const said = chart.parentElement.insertBefore(Object.assign(document.createElement("output"), { className: "mark" }), chart.nextSibling);
      chart.setAttribute("role", "group");
      chart.setAttribute("aria-label", `${chart.querySelector("svg").getAttribute("aria-label")}: arrow keys go through the marks`);
      let at = null;
      const go = (to) => {
        at?.part.classList.remove("at");
        at = to;
        said.textContent = at ? at.says : "";
        if (!at) return light([]);
        at.part.classList.add("at");
        at.part.scrollIntoView({ block: "nearest", inline: "nearest" });
        return point(at);
      };
      for (const mark of marks) mark.part.addEventListener("pointerenter", () => { said.textContent = mark.says; });
      chart.addEventListener("blur", () => go(null));
      chart.addEventListener("keydown", (event) => {
        const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
        const shown = marks.filter(({ part }) => !part.classList.contains("aside"));
        if (!by || shown.length === 0) return;
        event.preventDefault();
        const now = shown.indexOf(at);
        go(shown[now < 0 ? (by > 0 ? 0 : shown.length - 1) : (now + by + shown.length) % shown.length]);
      });
    }
  }
  // The sections by name, to be gone to; a long page has many.
  const titles = [...document.querySelectorAll("section > h2")];
  const list = Object.assign(document.createElement("nav"), { ariaLabel: "Sections" });
  list.append(...titles.map((title) => {
    const id = title.textContent.toLowerCase().replaceAll(" ", "-");
    title.id = id;
    return Object.assign(document.createElement("a"), { href: `#${id}`, textContent: title.textContent });
  }));
  document.querySelector("header").append(list);
  document.getElementById(decodeURIComponent(location.hash.slice(1)))?.scrollIntoView();
  document.documentElement.dataset.drawn = figures.length;
})();
