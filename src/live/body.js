// Draws meshes flat, from behind to the front: a browser without a graphics card does so many times a second.
const Body = (place, { meshes, room }) => {
  // Receptors from untouched to touched just now.
  const GLOW = [[147, 161, 173], [246, 213, 115], [242, 142, 60], [215, 48, 31]];
  // Receptors lie on the skin: they are drawn after what is no farther behind them, metres.
  const LIFT = 0.025;
  // How far a mouse may go that only clicks, pixels.
  const CLICK = 4;
  const context = place.getContext("2d");
  const view = { turn: 0.5, tilt: 0.28, zoom: 1 };
  const middle = [0, 1, 2].map((k) => (room[0][k] + room[1][k]) / 2);
  const colours = meshes.map(({ colour }) => colour && [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16)));
  const places = meshes.map(() => null);
  let glow = [];
  let faces = [];

  const shaded = ([r, g, b], light) => `rgb(${(r * light) | 0},${(g * light) | 0},${(b * light) | 0})`;
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

  const draw = () => {
    const ratio = Math.min(devicePixelRatio, 1.5);
    const [width, height] = [place.clientWidth, place.clientHeight];
    if (place.width !== Math.round(width * ratio) || place.height !== Math.round(height * ratio)) {
      [place.width, place.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    }
    const [right, up, ahead] = axes();
    const half = [0, 1, 2].map((k) => (room[1][k] - room[0][k]) / 2);
    const spread = (axis) => axis.reduce((sum, x, k) => sum + Math.abs(x) * half[k], 0);
    const scale = view.zoom * Math.min(width / (2 * spread(right)), height / (2 * spread(up)));
    faces = [];
    meshes.forEach((mesh, m) => {
      const at = places[m];
      if (!at) return;
      const n = at.length / 3;
      const [x, y, z] = [new Float32Array(n), new Float32Array(n), new Float32Array(n)];
      for (let k = 0; k < n; k += 1) {
        const [a, b, c] = [at[3 * k] - middle[0], at[3 * k + 1] - middle[1], at[3 * k + 2] - middle[2]];
        x[k] = width / 2 + scale * (right[0] * a + right[1] * b + right[2] * c);
        y[k] = height / 2 - scale * (up[0] * a + up[1] * b + up[2] * c);
        z[k] = ahead[0] * a + ahead[1] * b + ahead[2] * c;
      }
      const face = (corners, receptor) => {
        const [i, j, k] = corners;
        const [ux, uy, uz] = [x[j] - x[i], y[j] - y[i], (z[j] - z[i]) * scale];
        const [vx, vy, vz] = [x[k] - x[i], y[k] - y[i], (z[k] - z[i]) * scale];
        // Pixels go down: what faces who looks turns the other way round.
        const toward = uy * vx - ux * vy;
        if (toward <= 0) return;
        const [nx, ny] = [uy * vz - uz * vy, uz * vx - ux * vz];
        const facing = toward / Math.hypot(nx, ny, toward);
        const depth = corners.reduce((sum, c) => sum + z[c], 0) / corners.length;
        faces.push({
          depth: depth + (receptor >= 0 ? LIFT : 0),
          at: corners.map((c) => [x[c], y[c]]),
          light: 0.5 + 0.5 * Math.round(12 * facing) / 12,
          mesh: m,
          receptor,
        });
      };
      if (mesh.triangles) mesh.triangles.forEach((triangle) => face(triangle, -1));
      else for (let r = 0; 4 * r < n; r += 1) face([4 * r, 4 * r + 1, 4 * r + 2, 4 * r + 3], r);
    });
    faces.sort((a, b) => a.depth - b.depth);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    for (const { at, light, mesh, receptor } of faces) {
      const colour = shaded(receptor < 0 ? colours[mesh] : glowing(glow[receptor] || 0), light);
      context.fillStyle = colour;
      context.beginPath();
      at.forEach(([a, b], k) => (k ? context.lineTo(a, b) : context.moveTo(a, b)));
      context.closePath();
      context.fill();
      if (receptor < 0) {
        // No ground shows between triangles.
        context.strokeStyle = colour;
        context.stroke();
      }
    }
  };

  const inside = ([px, py], at) => {
    let within = false;
    for (let i = 0, j = at.length - 1; i < at.length; j = i, i += 1) {
      const [[ax, ay], [bx, by]] = [at[i], at[j]];
      if (ay > py !== by > py && px < ((bx - ax) * (py - ay)) / (by - ay) + ax) within = !within;
    }
    return within;
  };
  const centre = ({ at }) => [0, 1].map((k) => at.reduce((sum, p) => sum + p[k], 0) / at.length);

  // The receptor at a point of the picture: the one that is seen there, or the nearest one in sight on skin beside it.
  const receptorAt = (point) => {
    const hit = faces.findLast((face) => inside(point, face.at));
    if (!hit || hit.receptor >= 0) return hit ? hit.receptor : -1;
    const skin = meshes.findIndex((mesh) => !mesh.triangles);
    if (skin < 0 || meshes[hit.mesh].poses !== meshes[skin].poses) return -1;
    const far = (face) => Math.hypot(centre(face)[0] - point[0], centre(face)[1] - point[1]);
    const seen = faces.filter((face) => face.receptor >= 0);
    return seen.length ? seen.reduce((best, face) => (far(face) < far(best) ? face : best)).receptor : -1;
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
      const face = faces.find((face) => face.receptor === receptor);
      return face && receptorAt(centre(face)) === receptor ? centre(face) : null;
    },
  };
};
