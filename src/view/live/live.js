// Shows what the page is told: the newest state counts, what was missed is left out.
(() => {
  "use strict";
  const element = (id) => document.getElementById(id);
  const body = Body(document.querySelector("figure.body"));
  // How often the body is drawn at most, milliseconds; and how much of a light is left each time.
  const EVERY = 50;
  const FADE = 0.75;
  // How touched a receptor looks that was touched just now.
  const LIT = 0.8;
  // How often curves are drawn.
  const CURVE_EVERY = 2000;
  let newest = null;
  // Whether the body was pulled to where no state has it yet.
  let ahead = false;
  let last = null;
  let before = null;
  let glow = [];
  let placed = "";
  let drawnAt = -Infinity;
  let due = false;
  let curvesDue = false;
  let told = "";
  // For who measures: how often something new was drawn, and where a receptor is in the picture.
  window.live = { updates: 0, whereIs: body.whereIs };

  // What receptors look like next, and whether that is another thing than before.
  const lights = (state) => {
    const was = glow;
    glow = glow.map((light) => (light > 0.02 ? light * FADE : 0));
    if (state.lit && before) state.lit.forEach((n, k) => { if (n !== before[k]) glow[k] = LIT; });
    before = state.lit;
    for (const k of state.felt || []) glow[k] = LIT;
    glow = Array.from(glow, (light) => light || 0);
    return glow.some((light, k) => light !== (was[k] || 0));
  };

  const curves = async () => {
    curvesDue = false;
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

  const send = (asked) =>
    fetch("ask", { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(asked) });

  // What this browser looks at, which nobody else knows: a touch or a posture of a session, and another one beside it.
  const looked = document.querySelector("[data-session]");
  const number = (text) => (text === "" ? null : Number(text));
  const asked = looked && { session: number(looked.dataset.session), beside: number(looked.dataset.beside), touch: 0 };
  const looking = (state) => {
    if (!ahead) body.take(state.posture);
    element("doing").className = `verdict ${state.tone}`;
    if (element("touch")) {
      element("touch").value = state.touch;
      element("touch-number").textContent = state.touch || "rest";
    }
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
      const link = Object.assign(document.createElement("a"), { href: "report", textContent: "the report" });
      element("doing").append(". While this page is served, see ", link, `; it is saved as ${state.report}`);
    }
  };

  // Draws what is new, and goes on as long as lights change: at rest nothing is drawn.
  const soon = () => {
    if (due) return;
    due = true;
    setTimeout(draw, Math.max(0, drawnAt + EVERY - performance.now()));
  };
  const draw = () => {
    due = false;
    drawnAt = performance.now();
    const state = newest;
    const poses = JSON.stringify(state.poses);
    const changes = lights(state);
    if (changes || poses !== placed) body.show(ahead ? {} : state.poses, glow);
    placed = poses;
    if (state !== last) {
      last = state;
      words(state);
      window.live.updates += 1;
    }
    if (changes) soon();
  };
  const receive = (state) => {
    newest = state;
    // It is drawn even if it is the same as the last: the body is elsewhere.
    if (ahead) [ahead, placed] = [false, ""];
    soon();
    // Of the last state there are no later ones to be drawn with.
    if (!state.wanted || (curvesDue && !state.report)) return;
    curvesDue = true;
    setTimeout(() => curves().catch(() => {}), window.live.updates && !state.report ? CURVE_EVERY : 0);
  };

  const form = element("say");
  if (form) {
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const text = element("text").value.trim();
      element("text").value = "";
      // What was not taken is there to be said again, unless something else is typed by then.
      const back = () => { element("text").value ||= text; };
      if (text) send({ say: text }).then((answer) => { if (!answer.ok) back(); }, back);
    });
    body.onReceptor((receptor) => send({ touch: receptor }));
  }

  if (looked) {
    // One at a time: of what is asked meanwhile the last counts.
    let waits = false;
    let again = false;
    const show = async (changes) => {
      Object.assign(asked, changes);
      again = true;
      if (waits) return;
      waits = true;
      while (again) {
        again = false;
        const answer = await send({ show: asked }).catch(() => null);
        if (answer?.ok) receive(await answer.json());
      }
      waits = false;
    };
    element("touch")?.addEventListener("input", () => show({ touch: Number(element("touch").value), posture: null }));
    // Another body is another page.
    for (const id of ["shown", "beside"]) {
      element(id)?.addEventListener("change", () => {
        location.search = `session=${element("shown").value}&beside=${element("beside").value}`;
      });
    }
    body.onPosture((pulled) => {
      ahead = true;
      show({ posture: pulled, touch: 0 });
    });
    show({});
  }

  const source = new EventSource("events");
  source.onmessage = (event) => {
    const state = JSON.parse(event.data);
    if (state.poses) receive(state);
  };
  source.onopen = () => { delete document.documentElement.dataset.lost; };
  source.onerror = () => { document.documentElement.dataset.lost = "lost"; };
})();
