// The report: its body is drawn at once, all else is there already.
(() => {
  const figures = [...document.querySelectorAll("figure.body")];
  figures.forEach((figure) => Body(figure));
  document.documentElement.dataset.drawn = figures.length;
})();
