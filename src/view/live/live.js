// Shows what the page is told: the newest state counts, what was missed is left out.
(async () => {
  "use strict";
  const element = (id) => document.getElementById(id);
  const body = Body(document.querySelector("figure.body"));
  // How often the body is drawn, milliseconds; and how much of a light is left each time.
  const EVERY = 50;
  const FADE = 0.75;
  // How touched a receptor looks that was touched just now.
  const LIT = 0.8;
  // How often curves are drawn.
  const CURVE_EVERY = 2000;
  // How often a pace is asked for, milliseconds.
  const PACE_EVERY = 1000;
  let newest = null;
  let last = null;
  let before = null;
  let glow = [];
  let curvesAt = -Infinity;
  let told = "";
  // For who measures: how often something new was drawn, and where a receptor is in the picture.
  window.live = { updates: 0, whereIs: body.whereIs };

  const lights = (state) => {
    glow = glow.map((light) => (light > 0.02 ? light * FADE : 0));
    if (state.lit && before) state.lit.forEach((n, k) => { if (n !== before[k]) glow[k] = LIT; });
    before = state.lit;
    for (const k of state.felt || []) glow[k] = LIT;
    glow = Array.from(glow, (light) => light || 0);
  };

  const curves = async () => {
    const charts = await (await fetch("charts")).json();
    for (const [name, svg] of Object.entries(charts)) element(name).innerHTML = svg;
  };

  const dialogue = (lines) => {
    if (told === JSON.stringify(lines)) return;
    told = JSON.stringify(lines);
    element("lines").replaceChildren(...lines.map(([who, said]) => {
      const line = document.createElement("li");
      line.className = who === "you" ? "you" : "own";
      line.append(Object.assign(document.createElement("b"), { textContent: who }), said);
      return line;
    }));
    element("lines").scrollTop = element("lines").scrollHeight;
  };

  // What is looked at: a touch, a posture, a session, and another one beside it.
  const dofs = [...document.querySelectorAll("[data-coordinate]")];
  let posture = [];
  let limb = null;
  const space = async () => {
    const shown = element("space").checked;
    element("space-says").textContent = shown ? "…" : "";
    if (!shown) {
      body.space(null);
      return;
    }
    const found = await (await fetch("space")).json();
    if (!element("space").checked) return;
    element("space-says").textContent = found.says;
    body.space({ ...found.cloud, poses: "learned" });
  };
  let edition = null;
  const looking = (state) => {
    // Another page asked for another body.
    if (edition !== null && edition !== state.edition) location.reload();
    ({ posture, edition } = state);
    element("about").textContent = state.about;
    element("doing").className = `verdict ${state.tone}`;
    if (limb !== state.limb) {
      limb = state.limb;
      if (element("space").checked) space().catch(() => {});
    }
    if (element("touch")) {
      element("touch").value = state.touch;
      element("touch-number").textContent = state.touch || "at ease";
    }
    for (const dof of dofs) if (dof !== document.activeElement) dof.value = posture[dof.dataset.coordinate];
  };

  const words = (state) => {
    if (state.lines) dialogue(state.lines);
    if (!state.wanted) {
      element("doing").textContent = state.doing;
      if (state.posture) looking(state);
      return;
    }
    const rate = state.rate ? `, ${state.rate} a second` : "";
    const learned = state.learnedFrom ? `; learned from ${state.learnedFrom}` : "";
    element("doing").textContent = `${state.doing}: ${state.touches} of ${state.wanted} touches${rate}${learned}`;
    if (state.report) {
      document.querySelector(".pace")?.setAttribute("hidden", "");
      const link = Object.assign(document.createElement("a"), { href: "report", textContent: "the report" });
      element("doing").append(". As long as this page is served: ", link, `; it stays in ${state.report}`);
    }
  };

  const send = (path, body) =>
    fetch(path, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });
  const form = element("say");
  if (form) {
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const text = element("text").value.trim();
      element("text").value = "";
      // What was not taken is there to be said again, unless something else is typed by then.
      const back = () => { element("text").value ||= text; };
      if (text) send("say", { text }).then((answer) => { if (!answer.ok) back(); }, back);
    });
    body.onReceptor((receptor) => send("touch", { receptor }));
  }

  if (element("about")) {
    const show = (asked) => send("show", asked).catch(() => {});
    element("touch")?.addEventListener("input", () => show({ touch: Number(element("touch").value) }));
    for (const dof of dofs) {
      dof.addEventListener("input", () => {
        posture[dof.dataset.coordinate] = Number(dof.value);
        show({ posture });
      });
    }
    const number = (id) => (element(id).value === "" ? null : Number(element(id).value));
    element("space").addEventListener("change", () => space().catch(() => {}));
    element("shown")?.addEventListener("change", () => show({ session: number("shown") }));
    element("beside")?.addEventListener("change", () => show({ beside: number("beside") }));
    body.onReceptor((receptor) => send("touch", { receptor }));
  }

  // A pace holds as long as it is asked for.
  const paces = [...document.querySelectorAll("[data-pace]")];
  let pace = null;
  const askPace = () => send("pace", { touches_a_second: pace }).catch(() => {});
  for (const button of paces) {
    button.addEventListener("click", () => {
      pace = button.dataset.pace === "" ? null : Number(button.dataset.pace);
      paces.forEach((other) => other.setAttribute("aria-pressed", other === button));
      askPace();
    });
  }
  setInterval(() => { if (pace !== null) askPace(); }, PACE_EVERY);

  const source = new EventSource("events");
  source.onmessage = (event) => { newest = event.data; };
  source.onopen = () => { delete document.documentElement.dataset.lost; };
  source.onerror = () => { document.documentElement.dataset.lost = "lost"; };
  for (;;) {
    const began = performance.now();
    const fresh = newest !== last;
    if (newest && (fresh || glow.some((light) => light > 0))) {
      const state = JSON.parse(newest);
      last = newest;
      lights(state);
      body.show(state.poses, glow);
      if (fresh) {
        words(state);
        window.live.updates += 1;
      }
      if (state.wanted && (began - curvesAt > CURVE_EVERY || state.report)) {
        curvesAt = began;
        curves().catch(() => {});
      }
    }
    await new Promise((done) => setTimeout(done, Math.max(1, EVERY - (performance.now() - began))));
  }
})();
