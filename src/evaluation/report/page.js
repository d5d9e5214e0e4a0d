// Draws the pictures of the page from the data beside them, in the colours of the reader's screen.
(() => {
  "use strict";
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const print = matchMedia("print");
  // The width of a printed page's text, in pixels of its style.
  const PAPER = 680;

  const template = () => {
    const black = dark.matches && !print.matches;
    const ink = black ? "#d5dbe1" : "#2b3640";
    const line = black ? "#39424c" : "#dfe3e8";
    const axis = { color: ink, gridcolor: line, zerolinecolor: line, linecolor: line };
    return {
      layout: {
        font: { color: ink, size: 13, family: getComputedStyle(document.body).fontFamily },
        paper_bgcolor: "rgba(0,0,0,0)",
        plot_bgcolor: "rgba(0,0,0,0)",
        xaxis: axis,
        yaxis: axis,
        legend: { bgcolor: "rgba(0,0,0,0)" },
        modebar: { bgcolor: "rgba(0,0,0,0)", color: black ? "#77828d" : "#9aa5b1", activecolor: ink },
        hoverlabel: { bgcolor: black ? "#10151a" : "#ffffff", font: { color: ink } },
        updatemenudefaults: { bordercolor: line, bgcolor: black ? "#1d2730" : "#f3f5f7" },
        sliderdefaults: { bordercolor: line, bgcolor: black ? "#2a333c" : "#eef1f4", tickcolor: ink },
      },
    };
  };

  // The library is a megabyte of work for the browser: it is read once the page itself is there to be read.
  const load = () => {
    const text = document.getElementById("library");
    if (!text) return;
    const script = document.createElement("script");
    script.textContent = text.textContent;
    text.remove();
    document.head.append(script);
  };

  // Pictures wait until they are about to be seen, or printed: a page opens as fast as its first picture.
  const waiting = new Set(document.querySelectorAll("script[data-plot]"));
  const places = [];
  const draw = async (data) => {
    if (!waiting.delete(data)) return;
    load();
    const place = document.getElementById(data.dataset.plot);
    const plot = JSON.parse(data.textContent);
    plot.layout.template = template();
    // As sharp as the screen is, and no more: without a graphics card every pixel takes its time.
    plot.config.plotGlPixelRatio = Math.max(1, Math.min(2, devicePixelRatio));
    places.push(place);
    await Plotly.newPlot(place, plot.data, plot.layout, plot.config);
    // Where the browser draws nothing in three dimensions, the still is better than an apology.
    const still = place.querySelector(".still");
    if (still && place.querySelector(".no-webgl")) place.querySelector(".plot-container").remove();
    else if (still) still.remove();
    place.dataset.drawn = "";
    performance.mark(`drawn ${place.id}`);
  };
  // One at a time, with a breath between them in which the page can be scrolled.
  const queue = [];
  let busy = false;
  const work = async () => {
    if (busy) return;
    busy = true;
    while (queue.length > 0) {
      await new Promise((done) => setTimeout(done));
      await draw(queue.shift());
    }
    busy = false;
    document.documentElement.dataset.drawn = places.length;
  };
  const watch = new IntersectionObserver(
    (seen) => {
      for (const { isIntersecting, target } of seen) {
        if (!isIntersecting) continue;
        watch.unobserve(target);
        queue.push(target.nextElementSibling);
      }
      work();
    },
    { rootMargin: "25% 0px" },
  );
  const start = () => waiting.forEach((data) => watch.observe(data.previousElementSibling));
  if (document.readyState === "complete") start();
  else addEventListener("load", start);

  const redraw = (size) =>
    places.forEach((place) => Plotly.relayout(place, { template: template(), ...size }));
  dark.addEventListener("change", () => redraw({}));
  addEventListener("beforeprint", () => {
    waiting.forEach(draw);
    redraw({ width: PAPER, autosize: false });
  });
  addEventListener("afterprint", () => redraw({ width: null, autosize: true }));
})();
