// A figure of a body: it is turned, zoomed, pointed at, its layers switched, moved through steps, and pulled by its limbs.
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
  const PLAY = "▶ play learning";
  const STOP = "❚❚ stop";
  const LEAST_PLAYED = 4000;
  const MOST_PLAYED = 9000;
  const EACH_PLAYED = 600;
  const HELD = 700;
  const TINY = 1e-4;
  // How far a key pulls a limb, as a share of the body's size; and the colour of what is pulled and of a touch.
  const KEY_PULLS = 0.06;
  const MARK = "#d11a6e";

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

  const element = (name, properties, ...children) => {
    const made = Object.assign(document.createElement(name), properties);
    made.append(...children);
    return made;
  };
  const canvas = figure.querySelector("canvas");
  const context = canvas.getContext("2d", { willReadFrequently: true });
  const tip = figure.querySelector(".tip");
  const scene = JSON.parse(figure.querySelector("script").textContent);
  const poses = { ...scene.poses };
  // What lies along, as a snake does, is a ball from ahead.
  const [long, wide, high] = [0, 1, 2].map((k) => scene.room[1][k] - scene.room[0][k]);
  const view = { turn: long > 2 * Math.max(wide, high) ? 1.2 : 0.55, tilt: 0.2, zoom: 1 };
  const { layers, paint, project, unproject, placed, localOf, cameraOf, point } = Paint(scene, poses);
  const skeletons = scene.skeletons.map((skeleton) => ({ ...skeleton, shown: true, joints: [] }));
  const auras = scene.auras.map((own) => ({ ...own, shown: false }));
  const maps = scene.maps.map((own) => ({ ...own, shown: false }));
  const skin = layers.find(({ look }) => look === "receptors");
  let values = scene.values;
  // What is operated stands above the legend and the caption, the switches between the two.
  const panel = figure.querySelector(".panel").firstElementChild;
  const { steps } = scene;
  const play = element("button", { type: "button", className: "play", textContent: PLAY });
  const off = element("output", { className: "off" });
  const count = element("output", { textContent: steps.at(-1)?.name });
  const slider = steps.length > 1 ? element("input", { type: "range", min: 0, max: steps.length - 1, value: steps.length - 1 }) : null;
  if (slider) {
    panel.before(element("div", { className: "player" }, play, off), element("label", { className: "slider" }, "touches: ", count, slider));
  }
  let lit = new Set();
  let touched = [];
  // The limb that is chosen, those that are pointed at elsewhere in the page, and what is pulled: a point of a limb, and where to.
  let picked = null;
  let pointed = [];
  let pulled = null;
  // Where the schema has the limbs in other postures than the one that the page begins with; null where it is in that one.
  const size = Math.hypot(long, wide, high) / (2 * PARTS);
  const kinematics = scene.joints.length > 0 ? Kinematics(scene.joints, size) : null;
  let posture = null;
  let seen = null;
  let draws = 0;

  // The middle of the corners of a piece, or of all pieces of a limb, in the limb's frame.
  const middleOf = (mesh, piece, limb = null) => {
    const own = new Set();
    mesh.of.forEach((of, t) => {
      if (limb === null ? of === piece : mesh.limbs[of] === limb) for (let k = 0; k < 3; k += 1) own.add(mesh.faces[3 * t + k]);
    });
    return [0, 1, 2].map((k) => [...own].reduce((sum, corner) => sum + mesh.local[3 * corner + k], 0) / own.size);
  };

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

  // What is pulled and where to, and the receptors of a touch: they are seen through the body.
  const marks = (camera, ratio) => {
    const dot = ([x, y], radius) => {
      context.beginPath();
      context.arc(x, y, radius * ratio, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    };
    const line = (ends, dashes) => {
      context.setLineDash(dashes.map((dash) => dash * ratio));
      context.beginPath();
      ends.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
      context.stroke();
      context.setLineDash([]);
    };
    const marked = (ends, dashes) => {
      [context.strokeStyle, context.lineWidth] = [MARK, 1.6 * ratio];
      line(ends, dashes);
      [context.fillStyle, context.strokeStyle] = [MARK, "#ffffff"];
      ends.forEach((at) => dot(at, 4.5));
    };
    if (pulled) marked([placed(poses.learned, pulled.limb, pulled.local), pulled.target].map((p) => project(camera, p)), [4, 4]);
    if (touched.length > 0 && poses[skin.poses]) {
      marked(touched.map((receptor) => project(camera, placed(poses[skin.poses], skin.mesh.limbs[receptor], middleOf(skin.mesh, receptor)))), [2, 5]);
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
    marks(camera, ratio);
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
    if (pulled && !pulled.done) follow();
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
    if (!there) return "";
    const { labels, look, mesh, poses: of } = there.layer;
    return labels?.[there.piece] || (look !== "ghost" && of === "learned" && scene.says[mesh.limbs[there.piece]]) || "";
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
  // A limb is chosen by a click, by the list of limbs or by a key, and it is pulled by a drag or by keys: the joints between the
  // root and it follow within their ranges.
  const chooser = kinematics && element("select", { autocomplete: "off" }, new Option("all", ""));
  const restButton = element("button", { type: "button", hidden: true, textContent: "rest posture" });
  const said = element("output", { className: "said", textContent: "Choose or pull a limb to see how well it is located." });
  const dofs = element("div", { className: "dofs" });
  const hint = element("div", { className: "hint", textContent: "Drag a limb to pull it." });
  if (kinematics) {
    const postureOf = element("details", { className: "posture" }, element("summary", { textContent: "Move joint by joint" }), dofs);
    panel.before(element("div", { className: "limb" }, element("label", {}, "limb: ", chooser), restButton), said, postureOf);
    figure.querySelector(".stage").append(hint);
    // Creatures have up to a thousand of them: they are made once they are asked for.
    postureOf.addEventListener("toggle", () => {
      if (dofs.childElementCount === 0) dofs.append(...kinematics.dofs.filter(({ kind, follows }) => kind !== "ball" && !follows).map(sliderOf));
      showCoordinates();
    });
  }
  const sliderOf = ({ name, range: [min, max], coordinate }) => {
    const own = element("input", { type: "range", min, max, step: "any" });
    own.dataset.coordinate = coordinate;
    own.addEventListener("input", () => {
      const next = [...(posture || kinematics.rest)];
      next[coordinate] = Number(own.value);
      toLast();
      pose(kinematics.allowed(next));
      postureTaken?.(posture);
    });
    return element("label", {}, name, own);
  };
  const showCoordinates = () => {
    for (const own of dofs.querySelectorAll("input")) {
      if (own !== document.activeElement) own.value = (posture || kinematics.rest)[own.dataset.coordinate];
    }
  };
  let clicked = () => {};
  let limbPicked = () => {};
  let postureTaken = null;
  const relight = () => {
    lit = new Set([...pointed, ...(picked === null ? [] : [picked]), ...(pulled ? [pulled.limb] : [])]);
    soon();
  };
  const say = (limb, reach = "") => {
    said.textContent = limb === null ? "" : `${scene.says[limb]}.${reach}`;
  };
  const pick = (limb) => {
    picked = limb;
    if (chooser) chooser.value = limb ?? "";
    say(limb);
    relight();
    limbPicked(limb);
  };
  const kept = {};
  // Puts the body into a posture; null is the one that the page begins with. A body that does not follow is not drawn meanwhile.
  const pose = (next) => {
    if (!posture) Object.assign(kept, poses);
    posture = next;
    if (!next) Object.assign(poses, kept);
    else if (!postureTaken) for (const name of Object.keys(poses)) if (name !== "learned") delete poses[name];
    if (next) poses.learned = kinematics.pose(next);
    restButton.hidden = !next;
    showCoordinates();
    soon();
  };
  const follow = () => {
    const { limb, local, target } = pulled;
    const found = kinematics.pull(posture || kinematics.rest, limb, local, target);
    pulled.done = true;
    pose(found.posture);
    const short = (1e3 * found.off).toFixed(found.off < 0.01 ? 1 : 0);
    say(limb, found.reached ? " It gets there." : ` It gets to within ${short} mm of there.`);
    postureTaken?.(found.posture);
  };
  // Only what was learned in the end is moved.
  const toLast = () => {
    stop();
    if (!slider || slider.value === slider.max) return;
    slider.value = slider.max;
    toStep(steps.at(-1));
  };
  const pullTo = (limb, local, target) => {
    toLast();
    pulled = { limb, local, target };
    hint.remove();
    relight();
  };
  const letGo = () => {
    pulled = null;
    relight();
  };
  // The camera of the picture as pointers have it, and what of the body is at a place: a point of a limb that can be pulled.
  const cameraNow = () => cameraOf(view, canvas.clientWidth, canvas.clientHeight);
  const handleAt = (place) => {
    const there = kinematics && seen && shownAt(place);
    const limb = there && there.layer.poses === "learned" ? there.layer.mesh.limbs[there.piece] : null;
    if (limb === null || !kinematics.moves(limb)) return null;
    const [column, row] = place.map((p) => Math.floor(p * seen.ratio));
    const camera = cameraNow();
    const depth = seen.depth[row * seen.width + column] / seen.ratio;
    return { limb, depth, local: localOf(poses.learned, limb, unproject(camera, [...place, depth])) };
  };
  let held = null;
  canvas.addEventListener("pointerdown", (event) => {
    held = { x: event.clientX, y: event.clientY, moved: 0, handle: handleAt(placeOf(event)) };
    canvas.setPointerCapture(event.pointerId);
    tip.hidden = true;
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held) {
      canvas.classList.toggle("turns", !handleAt(placeOf(event)));
      tell(event);
      return;
    }
    const { handle } = held;
    const [dx, dy] = [event.clientX - held.x, event.clientY - held.y];
    held = { x: event.clientX, y: event.clientY, moved: held.moved + Math.abs(dx) + Math.abs(dy), handle };
    if (held.moved <= CLICK) return;
    if (handle) pullTo(handle.limb, handle.local, unproject(cameraNow(), [...placeOf(event), handle.depth]));
    else turn(dx, dy);
  });
  canvas.addEventListener("pointerup", (event) => {
    const clicks = held && held.moved <= CLICK && seen;
    held = null;
    if (pulled) {
      if (!pulled.done) follow();
      letGo();
    }
    if (!clicks) return;
    const receptor = receptorAt(placeOf(event));
    if (receptor !== NOBODY) clicked(receptor);
    const there = shownAt(placeOf(event));
    const limb = there ? there.layer.mesh.limbs[there.piece] : null;
    if (kinematics) pick(limb === picked ? null : limb);
    tell(event);
  });
  canvas.addEventListener("pointercancel", () => {
    held = null;
    if (pulled) letGo();
  });
  canvas.addEventListener("pointerleave", () => { tip.hidden = true; });
  // A finger on a limb pulls it, and beside the body it scrolls the page.
  canvas.addEventListener("touchstart", (event) => {
    const box = canvas.getBoundingClientRect();
    const [{ clientX, clientY }] = event.touches;
    if (event.touches.length === 1 && handleAt([clientX - box.left, clientY - box.top])) event.preventDefault();
  }, { passive: false });
  // Only limbs that are to be seen can be chosen.
  const limbs = [...new Set(layers.filter(({ poses: of, look }) => of === "learned" && look !== "ghost").flatMap(({ mesh }) => [...mesh.limbs]))];
  limbs.sort((a, b) => a - b);
  if (chooser) chooser.append(...limbs.map((limb) => new Option(scene.says[limb].split(": ")[0], limb)));
  chooser?.addEventListener("change", () => pick(chooser.value === "" ? null : Number(chooser.value)));
  const rest = () => {
    pose(null);
    postureTaken?.(kinematics.rest);
  };
  restButton.addEventListener("click", () => {
    rest();
    canvas.focus();
  });
  const pickNext = (by) => {
    const at = limbs.indexOf(picked);
    pick(limbs[(at < 0 ? (by > 0 ? 0 : limbs.length - 1) : at + by + limbs.length) % limbs.length]);
  };
  const keyPulls = (right, up) => {
    if (picked === null) pickNext(1);
    if (!kinematics.moves(picked)) return;
    const { mesh } = layers.find((layer) => layer.poses === "learned" && layer.look !== "ghost" && layer.mesh.limbs.includes(picked));
    const local = middleOf(mesh, null, picked);
    const [across, upwards] = cameraNow().axes;
    const from = placed(poses.learned, picked, local);
    pullTo(picked, local, from.map((x, k) => x + KEY_PULLS * size * (right * across[k] + up * upwards[k])));
    follow();
    letGo();
  };
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
  const limbKeys = {
    "Shift ArrowLeft": () => keyPulls(-1, 0),
    "Shift ArrowRight": () => keyPulls(1, 0),
    "Shift ArrowUp": () => keyPulls(0, 1),
    "Shift ArrowDown": () => keyPulls(0, -1),
    n: () => pickNext(1),
    p: () => pickNext(-1),
    Escape: () => { rest(); pick(null); },
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = event.shiftKey && event.key.startsWith("Arrow");
    const own = (kinematics && limbKeys[arrow ? `Shift ${event.key}` : event.key]) || keys[event.key];
    if (!own) return;
    event.preventDefault();
    own();
  });

  const scale = figure.querySelector(".scale");
  const all = [...layers, ...skeletons, ...auras, ...maps];
  const switches = [...new Set([...scene.layers, ...skeletons, ...auras, ...maps].map(({ name }) => name))].map((name) => {
    const box = element("input", { type: "checkbox", checked: !scene.hidden.includes(name) });
    box.dataset.layer = name;
    const toggle = () => {
      const own = all.filter((part) => part.name === name);
      own.forEach((part) => { part.shown = box.checked; });
      if (scale && own.includes(skin)) scale.hidden = !box.checked;
      soon();
    };
    box.addEventListener("change", toggle);
    toggle();
    return element("label", {}, box, ` ${name}`);
  });
  figure.querySelector("figcaption").before(element("div", { className: "switches" }, ...switches));
  // Steps: a slider goes to one, and a button through all of them, limbs moving from where one has them to where the next
  // has them.
  const showStep = (name, mm) => {
    count.textContent = name;
    off.textContent = mm === null ? "" : `${errorNumber(mm)} mm`;
    soon();
  };
  const toStep = (step) => {
    if (posture) pose(null);
    Object.assign(poses, step.poses);
    showStep(step.name, step.mm);
  };
  let playing = false;
  const stop = () => {
    playing = false;
    play.textContent = PLAY;
  };
  slider?.addEventListener("input", () => {
    stop();
    toStep(steps[Number(slider.value)]);
  });
  const playAll = async () => {
    const last = steps.length - 1;
    const lasts = Math.min(MOST_PLAYED, Math.max(LEAST_PLAYED, last * EACH_PLAYED));
    playing = true;
    play.textContent = STOP;
    toStep(steps[0]);
    say(null);
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
  play.addEventListener("click", () => (playing ? stop() : playAll()));
  new ResizeObserver(soon).observe(canvas);
  addEventListener("beforeprint", sharp);

  if (Object.keys(poses).length > 0) moving();
  performance.mark("body drawn");
  const body = {
    // Puts the parts where they are now, with how much each receptor feels, and draws.
    show(newer, felt) {
      // What is pulled is already farther than who answers knows.
      Object.assign(poses, newer, pulled ? { learned: poses.learned } : {});
      values = felt;
      soon();
    },
    onReceptor(listener) { clicked = listener; },
    // The limb that is chosen; null where none is.
    onLimb(listener) { limbPicked = listener; },
    // The posture that a pull leads to, for who poses all that is shown.
    onPosture(listener) { postureTaken = listener; },
    limbs: scene.limbs,
    pick,
    // Limbs and receptors that the page points at.
    light(limbsThere, receptors = []) {
      pointed = limbsThere;
      touched = receptors;
      relight();
    },
    // The receptors that are drawn, by their names.
    receptors: Object.fromEntries((skin?.labels || []).map((label, k) => [label.split(": ")[0], k])),
    limbOf: (receptor) => skin.mesh.limbs[receptor],
    // For who tests: the posture, what of the body is at a place of the picture, and how far from a place that is, pixels.
    posture: () => posture,
    handleAt,
    farFrom({ limb, local }, [x, y]) {
      const [column, row] = project(cameraNow(), placed(poses.learned, limb, local));
      return Math.hypot(column - x, row - y);
    },
    take(given) {
      posture = given;
      restButton.hidden = kinematics.rest.every((x, k) => x === given[k]);
      showCoordinates();
    },
    kinematics,
    whereIs: (receptor) => (seen ? whereIs(receptor) : null),
    turn,
    poses,
    draws: () => draws,
  };
  canvas.body = body;
  return body;
};
