// Draws meshes into the picture's own pixels, the nearest of each kept: a browser without a graphics card does so many
// times a second.
const Body = (place, { meshes, room }) => {
  // Receptors from untouched to touched just now.
  const GLOW = [[147, 161, 173], [246, 213, 115], [242, 142, 60], [215, 48, 31]];
  // Receptors lie on the skin: they hide what is no farther before them, metres.
  const LIFT = 0.01;
  // How far a mouse may go that only clicks, pixels.
  const CLICK = 4;
  // What a pixel shows where it is no receptor: nothing, or a mesh, counted on from here downwards.
  const NOTHING = -1;
  const context = place.getContext("2d", { willReadFrequently: true });
  const view = { turn: 0.5, tilt: 0.28, zoom: 1 };
  const middle = [0, 1, 2].map((k) => (room[0][k] + room[1][k]) / 2);
  const colours = meshes.map(({ colour }) => colour && [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16)));
  const places = meshes.map(() => null);
  let glow = [];
  let picture = null;
  // Where the receptors that face who looks are in the picture.
  let receptors = new Map();

  const glowing = (light) => {
    const at = Math.min(Math.max(light, 0), 0.999) * (GLOW.length - 1);
    const k = Math.floor(at);
    return GLOW[k].map((x, i) => x + (GLOW[k + 1][i] - x) * (at - k));
  };

  // To the right, up, and towards who looks, with x ahead, y to the left and z up.
  const axes = () => {
    const [ct, st, ci, si] = [Math.cos(view.turn), Math.sin(view.turn), Math.cos(view.tilt), Math.sin(view.tilt)];
    return [[-st, ct, 0], [-ct * si, -st * si, ci], [ct * ci, st * ci, si]];
  };

  const resized = (ratio) => {
    const [width, height] = [place.clientWidth, place.clientHeight].map((x) => Math.max(1, Math.round(x * ratio)));
    if (!picture || place.width !== width || place.height !== height) {
      [place.width, place.height] = [width, height];
      const image = context.createImageData(width, height);
      picture = {
        image,
        ratio,
        pixels: new Uint32Array(image.data.buffer),
        depth: new Float32Array(width * height),
        shown: new Int32Array(width * height),
      };
    }
    picture.pixels.fill(0);
    picture.depth.fill(-Infinity);
    picture.shown.fill(NOTHING);
    return [width, height];
  };

  // Fills the pixels of a triangle whose corners are given in pixels, with their depth towards who looks.
  const fill = ([ax, ay, az], [bx, by, bz], [cx, cy, cz], colour, shows, width, height) => {
    const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    const [left, right] = [Math.max(0, Math.floor(Math.min(ax, bx, cx))), Math.min(width - 1, Math.ceil(Math.max(ax, bx, cx)))];
    const [top, low] = [Math.max(0, Math.floor(Math.min(ay, by, cy))), Math.min(height - 1, Math.ceil(Math.max(ay, by, cy)))];
    const { pixels, depth, shown } = picture;
    for (let y = top; y <= low; y += 1) {
      for (let x = left; x <= right; x += 1) {
        const b = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area;
        const c = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area;
        if (b < 0 || c < 0 || b + c > 1) continue;
        const z = az + b * (bz - az) + c * (cz - az);
        const at = y * width + x;
        if (z > depth[at]) [depth[at], pixels[at], shown[at]] = [z, colour, shows];
      }
    }
  };

  const draw = () => {
    const ratio = Math.min(devicePixelRatio, 1.5);
    const [width, height] = resized(ratio);
    const [right, up, ahead] = axes();
    const half = [0, 1, 2].map((k) => (room[1][k] - room[0][k]) / 2);
    const spread = (axis) => axis.reduce((sum, x, k) => sum + Math.abs(x) * half[k], 0);
    const scale = view.zoom * Math.min(width / (2 * spread(right)), height / (2 * spread(up)));
    receptors = new Map();
    meshes.forEach((mesh, m) => {
      const at = places[m];
      if (!at) return;
      const seen = (k) => {
        const p = [0, 1, 2].map((i) => at[3 * k + i] - middle[i]);
        const along = (axis) => axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
        return [width / 2 + scale * along(right), height / 2 - scale * along(up), along(ahead) + (mesh.triangles ? 0 : LIFT)];
      };
      const corners = Array.from({ length: at.length / 3 }, (_, k) => seen(k));
      const face = ([a, b, c], rgb, shows) => {
        const [ux, uy, uz] = [b[0] - a[0], b[1] - a[1], (b[2] - a[2]) * scale];
        const [vx, vy, vz] = [c[0] - a[0], c[1] - a[1], (c[2] - a[2]) * scale];
        // Pixels go down: what faces who looks turns the other way round.
        const toward = uy * vx - ux * vy;
        if (toward <= 0) return false;
        const light = 0.5 + (0.5 * toward) / Math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, toward);
        const [red, green, blue] = rgb.map((x) => (x * light) | 0);
        fill(a, b, c, ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0, shows, width, height);
        return true;
      };
      if (mesh.triangles) {
        mesh.triangles.forEach((triangle) => face(triangle.map((k) => corners[k]), colours[m], NOTHING - 1 - m));
        return;
      }
      for (let r = 0; 4 * r < corners.length; r += 1) {
        const [a, b, c, d] = corners.slice(4 * r, 4 * r + 4);
        const rgb = glowing(glow[r] || 0);
        const sides = [face([a, b, c], rgb, r), face([a, c, d], rgb, r)];
        if (sides.some((side) => side)) receptors.set(r, [0, 1].map((k) => (a[k] + b[k] + c[k] + d[k]) / 4 / ratio));
      }
    });
    context.putImageData(picture.image, 0, 0);
  };

  const shownAt = ([x, y]) => {
    const [column, row] = [x, y].map((p) => Math.round(p * picture.ratio));
    const inside = column >= 0 && row >= 0 && column < place.width && row < place.height;
    return inside ? picture.shown[row * place.width + column] : NOTHING;
  };

  // The receptor at a point of the picture: the one that is seen there, or the nearest one in sight on skin beside it.
  const receptorAt = (point) => {
    const shown = shownAt(point);
    if (shown >= NOTHING) return shown;
    const skin = meshes.findIndex((mesh) => !mesh.triangles);
    if (skin < 0 || meshes[NOTHING - 1 - shown].poses !== meshes[skin].poses) return NOTHING;
    const far = ([, at]) => Math.hypot(at[0] - point[0], at[1] - point[1]);
    const seen = [...receptors].filter(([receptor, at]) => shownAt(at) === receptor);
    return seen.length ? seen.reduce((best, other) => (far(other) < far(best) ? other : best))[0] : NOTHING;
  };

  let held = null;
  let clicked = () => {};
  place.addEventListener("pointerdown", (event) => {
    held = { x: event.clientX, y: event.clientY, moved: 0 };
    place.setPointerCapture(event.pointerId);
  });
  place.addEventListener("pointermove", (event) => {
    if (!held) return;
    const [dx, dy] = [event.clientX - held.x, event.clientY - held.y];
    held = { x: event.clientX, y: event.clientY, moved: held.moved + Math.abs(dx) + Math.abs(dy) };
    if (held.moved <= CLICK) return;
    view.turn -= dx / 150;
    view.tilt = Math.min(Math.max(view.tilt + dy / 150, -1.5), 1.5);
    draw();
  });
  place.addEventListener("pointerup", (event) => {
    const box = place.getBoundingClientRect();
    const receptor = receptorAt([event.clientX - box.left, event.clientY - box.top]);
    if (held && held.moved <= CLICK && receptor >= 0) clicked(receptor);
    held = null;
  });
  place.addEventListener("wheel", (event) => {
    event.preventDefault();
    view.zoom = Math.min(Math.max(view.zoom * Math.exp(-event.deltaY / 600), 0.5), 6);
    draw();
  }, { passive: false });
  addEventListener("resize", draw);

  return {
    // Puts the parts where they are now, and draws.
    show(poses, lights) {
      glow = lights;
      meshes.forEach((mesh, m) => {
        const parts = poses[mesh.poses];
        if (!parts) return;
        const at = new Float32Array(3 * mesh.corners.length);
        mesh.corners.forEach(([part, x, y, z], k) => {
          const p = parts[part];
          for (let i = 0; i < 3; i += 1) at[3 * k + i] = p[3 * i] * x + p[3 * i + 1] * y + p[3 * i + 2] * z + p[9 + i];
        });
        places[m] = at;
      });
      draw();
    },
    onReceptor(listener) { clicked = listener; },
    // Where a receptor is in the picture; none where it is not in sight.
    whereIs(receptor) {
      const at = receptors.get(receptor);
      return at && shownAt(at) === receptor ? at : null;
    },
  };
};
