// The report: its body is drawn at once, all else is there already. Marks of charts, by what they say before the colon, and rows of
// tables, by their first cell, belong to the limbs that they name: these light up, and a limb that is clicked picks them out.
(() => {
  const figures = [...document.querySelectorAll("figure.body")];
  for (const { limbs, light, onLimb } of figures.map(Body)) {
    const named = [...document.querySelectorAll(".chart title, section tbody th")].map((name) => ({
      part: name.parentElement,
      of: name.textContent.split(": ")[0].split(", ").flatMap((word) => limbs[word] || []),
    })).filter(({ of }) => of.length > 0);
    let picked = [];
    for (const { part, of } of named) {
      part.addEventListener("pointerenter", () => light([...picked, ...of]));
      part.addEventListener("pointerleave", () => light(picked));
    }
    onLimb((limb) => {
      picked = limb === null || picked.includes(limb) ? [] : [limb];
      light(picked);
      for (const { part, of } of named) part.classList.toggle("aside", picked.length > 0 && !of.includes(limb));
    });
  }
  document.documentElement.dataset.drawn = figures.length;
})();
