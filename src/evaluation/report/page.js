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

  const drawn = [];
  for (const data of document.querySelectorAll("script[data-plot]")) {
    const place = document.getElementById(data.dataset.plot);
    const plot = JSON.parse(data.textContent);
    plot.layout.template = template();
    // As sharp as the screen is, and no more: without a graphics card every pixel takes its time.
    plot.config.plotGlPixelRatio = Math.max(1, Math.min(2, devicePixelRatio));
    drawn.push(Plotly.newPlot(place, plot.data, plot.layout, plot.config));
  }
  const redraw = (size) =>
    document.querySelectorAll(".plot").forEach((place) => Plotly.relayout(place, { template: template(), ...size }));
  dark.addEventListener("change", () => redraw({}));
  addEventListener("beforeprint", () => redraw({ width: PAPER, autosize: false }));
  addEventListener("afterprint", () => redraw({ width: null, autosize: true }));
  Promise.all(drawn).then(() => {
    performance.mark("drawn");
    document.documentElement.dataset.drawn = drawn.length;
  });
})();
