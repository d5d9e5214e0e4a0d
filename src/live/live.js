// Moves the pictures of the page as it is told: the newest state counts, what was missed is left out.
(async () => {
  "use strict";
  const place = document.getElementById("body");
  const moving = JSON.parse(document.getElementById("moving").textContent);
  const element = (id) => document.getElementById(id);
  // How often the body is drawn, and how fast a light goes out: by how much each time.
  const EVERY = 50;
  const FADE = 0.75;
  // How often curves are drawn.
  const CURVE_EVERY = 1000;
  let newest = null;
  let shown = {};
  let glow = null;
  let before = null;
  let curvesAt = -Infinity;
  window.updates = 0;

  const ready = () => new Promise((done) => {
    const look = () => ("drawn" in document.documentElement.dataset ? done() : setTimeout(look, 20));
    look();
  });

  // Where a mesh's corners are, by the poses of its parts.
  const placed = (mesh, poses) => {
    const n = mesh.corners.length;
    const at = [new Array(n), new Array(n), new Array(n)];
    mesh.corners.forEach(([part, x, y, z], k) => {
      const p = poses[part];
      for (let i = 0; i < 3; i += 1) at[i][k] = p[3 * i] * x + p[3 * i + 1] * y + p[3 * i + 2] * z + p[9 + i];
    });
    return at;
  };

  const lights = (state) => {
    const mesh = moving.find((mesh) => mesh.receptors);
    const count = mesh.corners.length / 4;
    glow = glow || new Array(count).fill(0);
    glow = glow.map((light) => (light > 0.02 ? light * FADE : 0));
    if (state.lit) {
      if (before) state.lit.forEach((n, k) => { if (n !== before[k]) glow[k] = 1; });
      before = state.lit;
    }
    (state.felt || []).forEach((k) => { glow[k] = 1; });
    return glow.flatMap((light) => [light, light, light, light]);
  };

  const draw = async (state) => {
    const change = { x: [], y: [], z: [] };
    const traces = [];
    moving.forEach((mesh, k) => {
      const poses = state.poses && state.poses[mesh.poses];
      if (!poses || !mesh.corners.length) return;
      // What has not moved need not be drawn anew.
      const told = JSON.stringify(poses);
      if (shown[k] === told && !mesh.receptors) return;
      shown[k] = told;
      const at = placed(mesh, poses);
      change.x.push(at[0]);
      change.y.push(at[1]);
      change.z.push(at[2]);
      traces.push(k);
    });
    const lit = moving.findIndex((mesh) => mesh.receptors);
    if (lit >= 0) change.intensity = traces.map((k) => (k === lit ? lights(state) : undefined));
    if (traces.length) await Plotly.restyle(place, change, traces);
  };

  const curves = async (state) => {
    for (const name of ["made", "missed"]) {
      const points = state[name];
      if (!points || !element(name)) continue;
      await Plotly.restyle(name, { x: [points.map((p) => p[0])], y: [points.map((p) => p[1])] }, [0]);
    }
  };

  const words = (state) => {
    if (state.wanted) {
      const rate = state.rate ? `, ${state.rate} a second` : "";
      const learned = state.learnedFrom ? `; learned from ${state.learnedFrom}` : "";
      element("doing").textContent =
        `${state.doing}: ${state.touches} of ${state.wanted} touches${rate}${learned}`;
      if (state.report) {
        const link = Object.assign(document.createElement("a"), { href: "report", textContent: state.report });
        element("doing").append(". The report: ", link);
      }
      return;
    }
    element("doing").textContent = state.doing || "";
    const list = element("lines");
    const told = JSON.stringify(state.lines);
    if (!list || list.dataset.told === told) return;
    list.dataset.told = told;
    list.replaceChildren(...state.lines.map(([who, said]) => {
      const line = document.createElement("li");
      line.className = who === "you" ? "you" : "own";
      line.append(Object.assign(document.createElement("b"), { textContent: who }), said);
      return line;
    }));
    list.scrollTop = list.scrollHeight;
  };

  const send = (path, body) =>
    fetch(path, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });

  await ready();
  const form = element("say");
  if (form) {
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const text = element("text").value.trim();
      if (text) send("say", { text });
      element("text").value = "";
    });
    // The receptor under the mouse: four corners each.
    place.on("plotly_click", (event) => {
      const point = event.points[0];
      if (!moving[point.curveNumber].receptors) return;
      send("touch", { receptor: Math.floor(point.pointNumber / 4) });
    });
  }

  const source = new EventSource("events");
  source.onmessage = (event) => { newest = event.data; };
  source.onerror = () => { document.documentElement.dataset.lost = "lost"; };
  source.onopen = () => { delete document.documentElement.dataset.lost; };
  for (;;) {
    const began = performance.now();
    const state = newest ? JSON.parse(newest) : null;
    if (state && (newest !== shown.last || (glow && glow.some((light) => light > 0)))) {
      shown.last = newest;
      words(state);
      await draw(state);
      window.updates += 1;
      if (began - curvesAt > CURVE_EVERY || state.report) {
        await curves(state);
        curvesAt = began;
      }
    }
    await new Promise((done) => setTimeout(done, Math.max(1, EVERY - (performance.now() - began))));
  }
})();
