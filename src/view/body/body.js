// A figure of a body: it is turned, zoomed, pointed at, its layers switched, and moved through steps.
//
// The report and the live page hand it the same kind of data and get the same body.
const Body = (figure) => {
  // How far a mouse may go that only clicks, and how near a joint is pointed at, pixels.
  const CLICK = 4;
  const NEAR = 9;
  // How long nothing moves until the picture is drawn sharp, milliseconds; and the most pixels of that.
  const REST = 160;
  // A picture that took longer is drawn coarser the next time, milliseconds; and by how many of the screen's pixels.
  const SLOW = 24;
  const QUICK = [1, 0.8, 0.65, 0.5];
  const MOST_PIXELS = 3e6;
  const PARTS = 1e4;
  const BONE = "#1f6fb2";
  const OPEN = "#e08214";
  const NOBODY = -1;
  // The colours of auras, and how opaque each is.
  const VEILS = ["#3a8be0", "#1fae94", "#8f6fdc", "#e8963a", "#dc5a80"];
  const VEIL = 0.05;
  // Lines between neighbours on a limb and across limbs, and how far behind what is seen they still show, metres.
  const WITHIN = "#252c5c";
  const ACROSS = "#d11a6e";
  const BEFORE = 0.012;

  // What the button says while it plays; how long playing takes at the least, at the most and a step, and how long the first is held,
  // milliseconds; and errors below which all are alike.
  const STOP = "❚❚ stop";
  const LEAST_PLAYED = 4000;
  const MOST_PLAYED = 9000;
  const EACH_PLAYED = 600;
  const HELD = 700;
  const TINY = 1e-4;

  // As the report has errors: to two or three digits, and below a thousandth as that.
  const errorNumber = (x) => {
    if (x < 5e-4) return "< 0.001";
    return x >= 100 ? x.toFixed(0) : x >= 10 ? x.toFixed(1) : x >= 1 ? x.toFixed(2) : x.toFixed(3);
  };
  // A pose between two: of each limb a quaternion and an origin, and where it begins.
  const blend = (from, to, share) => {
    const mixed = (a, b) => a.map((x, k) => x + share * (b[k] - x));
    const frames = mixed(from.frames, to.frames);
    for (let k = 0; k < frames.length; k += 7) {
      const dot = [0, 1, 2, 3].reduce((sum, i) => sum + from.frames[k + i] * to.frames[k + i], 0);
      const q = [0, 1, 2, 3].map((i) => (1 - share) * from.frames[k + i] + share * Math.sign(dot || 1) * to.frames[k + i]);
      const length = Math.hypot(...q) / PARTS || 1;
      q.forEach((x, i) => { frames[k + i] = x / length; });
    }
    return { frames, begins: mixed(from.begins, to.begins) };
  };

  const canvas = figure.querySelector("canvas");
  const context = canvas.getContext("2d", { willReadFrequently: true });
  const tip = figure.querySelector(".tip");
  const scene = JSON.parse(figure.querySelector("script").textContent);
  const poses = { ...scene.poses };
  // What lies along, as a snake does, is a ball from ahead.
  const [long, wide, high] = [0, 1, 2].map((k) => scene.room[1][k] - scene.room[0][k]);
  const view = { turn: long > 2 * Math.max(wide, high) ? 1.2 : 0.55, tilt: 0.2, zoom: 1 };
  const { layers, paint, project, placed, cameraOf, point } = Paint(scene, poses);
  const skeletons = scene.skeletons.map((skeleton) => ({ ...skeleton, shown: true, joints: [] }));
  const auras = scene.auras.map((own) => ({ ...own, shown: false }));
  const maps = scene.maps.map((own) => ({ ...own, shown: false }));
  const skin = layers.find(({ look }) => look === "receptors");
  let values = scene.values;
  let lit = new Set();
  let seen = null;
  let draws = 0;

  // Joints are inside of limbs: they are drawn over all.
  const skeleton = (own, camera, ratio) => {
    const pose = poses[own.poses];
    const bold = own.look !== "ghost";
    const unit = ratio * Math.max(0.6, Math.min(1.6, camera.scales[0] / ratio / 320));
    const at = Array.from({ length: pose.begins.length / 3 }, (_, k) => project(camera, point(pose.begins, k)));
    const bones = own.parents.map((parent, joint) => [at[parent], at[joint + 1]]);
    for (const [limb, ...p] of own.tips) bones.push([at[limb], project(camera, placed(pose, limb, p.map((n) => n / PARTS)))]);
    context.lineCap = "round";
    context.strokeStyle = bold ? BONE : own.colour;
    context.lineWidth = (bold ? 2.2 : 1.2) * unit;
    context.globalAlpha = bold ? 0.8 : 0.6;
    context.beginPath();
    for (const [from, to] of bones) {
      context.moveTo(from[0], from[1]);
      context.lineTo(to[0], to[1]);
    }
    context.stroke();
    context.globalAlpha = 1;
    own.joints = at.slice(1).map(([x, y, z], joint) => ({ x: x / ratio, y: y / ratio, z, joint, own }));
    for (const { x, y, joint } of [...own.joints].sort((a, b) => a.z - b.z)) {
      context.beginPath();
      context.arc(x * ratio, y * ratio, (bold ? 3.6 : 2) * unit, 0, 2 * Math.PI);
      context.fillStyle = own.open.includes(joint) ? OPEN : bold ? BONE : own.colour;
      context.fill();
      if (!bold) continue;
      context.strokeStyle = "#ffffff";
      context.lineWidth = unit;
      context.stroke();
    }
  };

  // An aura is a capsule, and a capsule's outline the one of two circles: each is a veil with a thin edge.
  const aura = (own, camera, ratio) => {
    const pose = poses[own.poses];
    own.capsules.forEach(([limb, ...numbers], k) => {
      const [a, b] = [0, 3].map((from) => project(camera, placed(pose, limb, numbers.slice(from, from + 3).map((n) => n / PARTS))));
      const radius = (numbers[6] / PARTS) * camera.scales[0];
      const along = Math.atan2(b[1] - a[1], b[0] - a[0]);
      context.beginPath();
      context.arc(a[0], a[1], radius, along + Math.PI / 2, along - Math.PI / 2);
      context.arc(b[0], b[1], radius, along - Math.PI / 2, along + Math.PI / 2);
      context.closePath();
      context.fillStyle = context.strokeStyle = VEILS[k % VEILS.length];
      context.globalAlpha = VEIL;
      context.fill();
      context.globalAlpha = 0.55;
      context.lineWidth = ratio;
      context.stroke();
    });
    context.globalAlpha = 1;
  };

  // Lines between neighbouring receptors that are both in sight.
  const map = (own, camera, ratio) => {
    const pose = poses[own.poses];
    const at = own.points.map(([limb, ...p]) => project(camera, placed(pose, limb, p.map((n) => n / PARTS))));
    const sight = at.map(([x, y, z]) => {
      const [column, row] = [Math.floor(x), Math.floor(y)];
      const inside = column >= 0 && row >= 0 && column < seen.width && row < seen.height;
      return inside && seen.depth[row * seen.width + column] <= z + BEFORE * camera.scales[0];
    });
    context.lineCap = "round";
    for (const across of [false, true]) {
      context.strokeStyle = across ? ACROSS : WITHIN;
      context.lineWidth = (across ? 1.8 : 1.1) * ratio;
      context.beginPath();
      for (const [a, b] of own.links) {
        if (!sight[a] || !sight[b] || (own.points[a][0] !== own.points[b][0]) !== across) continue;
        context.moveTo(at[a][0], at[a][1]);
        context.lineTo(at[b][0], at[b][1]);
      }
      context.stroke();
    }
  };

  const draw = (ratio) => {
    if (canvas.clientWidth === 0) return;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((x) => Math.max(1, Math.round(x * ratio)));
    const camera = cameraOf(view, width, height);
    seen = { ...paint(context, camera, width, height, values, lit), ratio };
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    context.putImageData(seen.image, 0, 0);
    for (const own of auras) if (own.shown && poses[own.poses]) aura(own, camera, ratio);
    for (const own of maps) if (own.shown && poses[own.poses]) map(own, camera, ratio);
    for (const own of skeletons) if (own.shown && poses[own.poses]) skeleton(own, camera, ratio);
    draws += 1;
  };
  // Quick while something moves, sharp once it rests.
  let resting = 0;
  let asked = false;
  const sharp = () => {
    const most = Math.sqrt(MOST_PIXELS / Math.max(1, canvas.clientWidth * canvas.clientHeight));
    draw(Math.max(1, Math.min(2 * Math.max(1, Math.round(devicePixelRatio)), most)));
  };
  // … as quick as the computer takes, coarser where it is slow.
  let coarse = 0;
  const moving = () => {
    clearTimeout(resting);
    const began = performance.now();
    draw(QUICK[coarse] * devicePixelRatio);
    const took = performance.now() - began;
    coarse = Math.min(QUICK.length - 1, Math.max(0, coarse + (took > SLOW) - (took < SLOW / 3)));
    resting = setTimeout(sharp, REST + 2 * took);
  };
  const soon = () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; moving(); });
  };

  const shownAt = ([x, y]) => {
    const [column, row] = [x, y].map((p) => Math.floor(p * seen.ratio));
    const inside = column >= 0 && row >= 0 && column < seen.width && row < seen.height;
    const id = inside ? seen.shown[row * seen.width + column] : NOBODY;
    const layer = layers.find(({ first, mesh }) => id >= first && id < first + mesh.pieces);
    return layer ? { layer, piece: id - layer.first } : null;
  };
  // Where the middle of a receptor is in the picture; none where it is not in sight.
  const whereIs = (receptor) => {
    const { mesh: { of, faces }, at: [xs, ys] } = skin;
    const own = [...of.keys()].filter((t) => of[t] === receptor).flatMap((t) => [0, 1, 2].map((k) => faces[3 * t + k]));
    const at = [xs, ys].map((list) => own.reduce((sum, k) => sum + list[k], 0) / own.length / seen.ratio);
    const there = shownAt(at);
    return there && there.layer === skin && there.piece === receptor ? at : null;
  };
  // The receptor at a place in the picture: the one that is seen there, or the nearest in sight on skin beside it.
  const receptorAt = (place) => {
    const there = shownAt(place);
    if (!skin || !there || there.layer.poses !== skin.poses) return NOBODY;
    if (there.layer === skin) return there.piece;
    const known = Array.from({ length: skin.mesh.pieces }, (_, k) => [k, whereIs(k)]).filter(([, at]) => at);
    const far = ([, at]) => Math.hypot(at[0] - place[0], at[1] - place[1]);
    return known.length ? known.reduce((best, other) => (far(other) < far(best) ? other : best))[0] : NOBODY;
  };
  // What there is at a place, in words.
  const words = (place) => {
    const far = ({ x, y }) => Math.hypot(x - place[0], y - place[1]);
    const joints = skeletons.filter(({ shown }) => shown).flatMap((own) => own.joints);
    const [near] = joints.filter((at) => far(at) < NEAR).sort((a, b) => far(a) - far(b));
    if (near) return near.own.names[near.joint] + near.own.says;
    const there = shownAt(place);
    return (there && there.layer.labels && there.layer.labels[there.piece]) || "";
  };
  const placeOf = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const tell = (event) => {
    const at = placeOf(event);
    tip.textContent = seen ? words(at) : "";
    tip.hidden = !tip.textContent;
    tip.style.left = "0";
    tip.style.left = `${Math.max(4, Math.min(at[0] + 12, canvas.clientWidth - tip.offsetWidth - 4))}px`;
    tip.style.top = `${at[1] + 16}px`;
  };

  const turn = (right, down) => {
    view.turn -= right / 150;
    view.tilt = Math.min(Math.max(view.tilt + down / 150, -1.5), 1.5);
    soon();
  };
  const zoom = (by) => {
    view.zoom = Math.min(Math.max(view.zoom * by, 0.5), 8);
    soon();
  };
  let held = null;
  let clicked = () => {};
  let limbClicked = () => {};
  canvas.addEventListener("pointerdown", (event) => {
    held = { x: event.clientX, y: event.clientY, moved: 0 };
    canvas.setPointerCapture(event.pointerId);
    tip.hidden = true;
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held) {
      tell(event);
      return;
    }
    const [dx, dy] = [event.clientX - held.x, event.clientY - held.y];
    held = { x: event.clientX, y: event.clientY, moved: held.moved + Math.abs(dx) + Math.abs(dy) };
    if (held.moved > CLICK) turn(dx, dy);
  });
  canvas.addEventListener("pointerup", (event) => {
    const clicks = held && held.moved <= CLICK && seen;
    held = null;
    if (!clicks) return;
    const receptor = receptorAt(placeOf(event));
    if (receptor !== NOBODY) clicked(receptor);
    const there = shownAt(placeOf(event));
    limbClicked(there ? there.layer.mesh.limbs[there.piece] : null);
    tell(event);
  });
  canvas.addEventListener("pointercancel", () => { held = null; });
  canvas.addEventListener("pointerleave", () => { tip.hidden = true; });
  // A wheel by itself turns the page on; with Ctrl, as two fingers on a pad have it, it zooms.
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 600));
  }, { passive: false });
  for (const button of figure.querySelectorAll("[data-zoom]")) {
    button.addEventListener("click", () => zoom(Number(button.dataset.zoom)));
  }
  const keys = {
    ArrowLeft: () => turn(15, 0),
    ArrowRight: () => turn(-15, 0),
    ArrowUp: () => turn(0, 15),
    ArrowDown: () => turn(0, -15),
    "+": () => zoom(1.15),
    "-": () => zoom(1 / 1.15),
  };
  canvas.addEventListener("keydown", (event) => {
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });

  const scale = figure.querySelector(".scale");
  for (const box of figure.querySelectorAll("[data-layer]")) {
    const toggle = () => {
      const own = [...layers, ...skeletons, ...auras, ...maps].filter(({ name }) => name === box.dataset.layer);
      own.forEach((part) => { part.shown = box.checked; });
      if (scale && own.includes(skin)) scale.hidden = !box.checked;
      soon();
    };
    box.addEventListener("change", toggle);
    toggle();
  }
  // Steps: a slider goes to one, and a button through all of them, limbs moving from where one has them to where the next
  // has them.
  const slider = figure.querySelector("input[type=range]");
  const play = figure.querySelector(".play");
  const off = figure.querySelector(".off");
  const invites = play?.textContent;
  const count = figure.querySelector(".slider output");
  const showStep = (name, mm) => {
    count.textContent = name;
    if (off) off.textContent = mm === null ? "" : `${errorNumber(mm)} mm`;
    soon();
  };
  const toStep = (step) => {
    Object.assign(poses, step.poses);
    showStep(step.name, step.mm);
  };
  let playing = false;
  const stop = () => {
    playing = false;
    if (play) play.textContent = invites;
  };
  slider?.addEventListener("input", () => {
    stop();
    toStep(scene.steps[Number(slider.value)]);
  });
  const playAll = async () => {
    const { steps } = scene;
    const last = steps.length - 1;
    const lasts = Math.min(MOST_PLAYED, Math.max(LEAST_PLAYED, last * EACH_PLAYED));
    playing = true;
    play.textContent = STOP;
    toStep(steps[0]);
    for (const began = performance.now() + HELD; playing;) {
      const now = await new Promise(requestAnimationFrame);
      const at = Math.min(Math.max((now - began) / lasts, 0), 1) * last;
      if (!playing) return;
      if (at >= last) break;
      const [from, to, share] = [steps[Math.floor(at)], steps[Math.floor(at) + 1], at % 1];
      slider.value = Math.round(at);
      for (const [name, pose] of Object.entries(from.poses)) poses[name] = blend(pose, to.poses[name], share);
      const both = from.mm !== null && to.mm !== null;
      const touches = Math.round(from.touches + share * (to.touches - from.touches));
      // Errors fall by orders of magnitude.
      showStep(touches || from.name, both ? Math.max(from.mm, TINY) ** (1 - share) * Math.max(to.mm, TINY) ** share : null);
    }
    slider.value = last;
    toStep(steps[last]);
    stop();
  };
  play?.addEventListener("click", () => (playing ? stop() : playAll()));
  new ResizeObserver(soon).observe(canvas);
  addEventListener("beforeprint", sharp);

  if (Object.keys(poses).length > 0) moving();
  performance.mark("body drawn");
  const body = {
    // Puts the parts where they are now, with how much each receptor feels, and draws.
    show(newer, felt) {
      Object.assign(poses, newer);
      values = felt;
      soon();
    },
    onReceptor(listener) { clicked = listener; },
    // The limb that is clicked; null where there is none.
    onLimb(listener) { limbClicked = listener; },
    limbs: scene.limbs,
    light(limbs) {
      lit = new Set(limbs);
      soon();
    },
    whereIs: (receptor) => (seen ? whereIs(receptor) : null),
    turn,
    poses,
    draws: () => draws,
  };
  canvas.body = body;
  return body;
};
