"use strict";
// Numbers are told in so many parts of a metre, and of 1.
const PARTS = 1e4;

// Fills bodies into the pixels of a canvas: 13,000 triangles of Max in some 10 ms.
//
// By this script and not by WebGL, for most of those who read reports on servers and in virtual machines have no graphics
// card. Measured in Chromium 990 pixels wide on two cores without one: so many triangles take WebGL 150 ms a frame
// (SwiftShader), these pixels with all else 25 ms. A library that could do both (three.js) is half a page's bytes.
const Paint = (scene, poses) => {
  // Steps between the dark and the light side of a colour, with room at both ends for rounding.
  const SHADES = 64;
  const PAD = 2;
  // How much of its colour a side shows that is turned away from the light, one that faces it, …
  const DARK = 0.56;
  const BRIGHT = 1.08;
  // … and where the light comes from: to the right, up, and towards who looks.
  const LIGHT = [0.25, 0.6, 0.76];
  // The outlines of limbs: where a neighbouring pixel is so much farther away, metres, and how dark it is there.
  const STEP = 0.025;
  const OUTLINE = 0.72;
  // How opaque the shade of a body is that another stands before.
  const GHOST = 0.38;
  // Receptors, by values from 0 to 1: red, green and blue.
  const SCALE = [[0, 147, 161, 173], [0.25, 246, 213, 115], [0.55, 242, 142, 60], [0.8, 215, 48, 31], [1, 127, 0, 24]];
  const VALUES = 48;
  // As what value a limb is drawn that is pointed at elsewhere in the page.
  const LAMP = 0.5;
  const NOTHING = -1;
  // So much nearer than they are receptors are drawn, metres: cloth lies on the skin.
  const ON_CLOTH = 0.012;
  // Numbers of a part: three rows of a matrix with what is added, and the light as the part has it.
  const EACH = 15;

  const [low, high] = scene.room.map((corner) => corner.map((x) => x / PARTS));
  const middle = [0, 1, 2].map((k) => (low[k] + high[k]) / 2);
  const half = [0, 1, 2].map((k) => (high[k] - low[k]) / 2);

  // A colour from its dark to its light side, each as a pixel.
  const shades = (rgb, alpha = 1) => Uint32Array.from({ length: SHADES + 2 * PAD }, (_, k) => {
    const share = Math.min(Math.max((k - PAD) / (SHADES - 1), 0), 1);
    const light = DARK + (BRIGHT - DARK) * share;
    const [red, green, blue] = rgb.map((x) => Math.min(255, Math.round(x * light)));
    return ((Math.round(255 * alpha) << 24) | (blue << 16) | (green << 8) | red) >>> 0;
  });
  const hex = (colour) => [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16));
  const between = (value) => {
    const k = Math.max(1, SCALE.findIndex(([at]) => value <= at));
    const [[from, ...start], [to, ...end]] = [SCALE[k - 1], SCALE[k]];
    return start.map((x, i) => x + ((value - from) / (to - from)) * (end[i] - x));
  };
  const scale = Array.from({ length: VALUES + 1 }, (_, k) => shades(between(k / VALUES)));
  const lamp = shades(between(LAMP));

  // Corners and triangles of a mesh: in round pieces, neighbouring triangles share corners and so their light.
  const unpacked = (pieces) => {
    const [part, local, faces, of] = [[], [], [], []];
    pieces.forEach(([topology, limb, ...numbers], piece) => {
      const { round, triangles } = scene.topologies[topology];
      const corner = (k) => {
        part.push(limb);
        for (let i = 0; i < 3; i += 1) local.push(numbers[3 * k + i] / PARTS);
        return part.length - 1;
      };
      const first = part.length;
      if (round) for (let k = 0; 3 * k < numbers.length; k += 1) corner(k);
      for (const k of triangles) faces.push(round ? first + k : corner(k));
      for (let k = 0; k < triangles.length; k += 3) of.push(piece);
    });
    const normals = new Float32Array(local.length);
    for (let f = 0; f < faces.length; f += 3) {
      const [a, b, c] = [0, 1, 2].map((k) => 3 * faces[f + k]);
      const [u, v] = [b, c].map((to) => [0, 1, 2].map((i) => local[to + i] - local[a + i]));
      const across = [0, 1, 2].map((i) => u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
      for (const k of [a, b, c]) for (let i = 0; i < 3; i += 1) normals[k + i] += across[i];
    }
    for (let k = 0; k < normals.length; k += 3) {
      const length = Math.hypot(normals[k], normals[k + 1], normals[k + 2]) || 1;
      for (let i = 0; i < 3; i += 1) normals[k + i] /= length;
    }
    const parts = 1 + part.reduce((most, p) => Math.max(most, p), 0);
    const lists = { part: Uint16Array.from(part), local: Float32Array.from(local), faces: Uint32Array.from(faces) };
    return { ...lists, of: Uint16Array.from(of), normals, parts, pieces: pieces.length, limbs: pieces.map(([, limb]) => limb) };
  };
  const meshes = scene.meshes.map(unpacked);

  // Shades of bodies come last: they fill what is left. Every piece has a number of its own.
  let numbers = 0;
  const layers = [...scene.layers].sort((a, b) => (a.look === "ghost") - (b.look === "ghost")).map((layer) => {
    const mesh = meshes[layer.mesh];
    const made = {
      ...layer,
      mesh,
      first: numbers,
      shown: true,
      lut: layer.colour ? shades(hex(layer.colour), layer.look === "ghost" ? GHOST : 1) : null,
      luts: layer.palette?.map((colour) => shades(hex(colour))),
      at: [0, 1, 2, 3].map(() => new Float32Array(mesh.part.length)),
      matrices: new Float32Array(EACH * mesh.parts),
    };
    numbers += mesh.pieces;
    return made;
  });
  const firstGhost = layers.find(({ look }) => look === "ghost")?.first ?? numbers;

  // A camera for a picture of a size: to the right, up, and towards who looks, with x ahead, y to the left and z up.
  const cameraOf = ({ turn, tilt, zoom }, width, height) => {
    const [ct, st, ci, si] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
    const axes = [[-st, ct, 0], [-ct * si, -st * si, ci], [ct * ci, st * ci, si]];
    // As far away as all of it is in sight from wherever it is turned.
    const across = Math.hypot(half[0], half[1]);
    const up = Math.abs(si) * across + ci * half[2];
    const scaled = zoom * Math.min(width / (2 * across), height / (2 * up));
    const light = [0, 1, 2].map((k) => LIGHT.reduce((sum, share, row) => sum + share * axes[row][k], 0));
    return { axes, scales: [scaled, -scaled, scaled], centre: [width / 2, height / 2, 0], light };
  };
  const project = (camera, p) => camera.axes.map((axis, row) =>
    camera.centre[row] + camera.scales[row] * axis.reduce((sum, a, k) => sum + a * (p[k] - middle[k]), 0));
  // The place that is seen at a point of the picture, given how near it is.
  const unproject = (camera, at) => middle.map((m, k) => camera.axes.reduce((sum, axis, row) =>
    sum + (axis[k] * (at[row] - camera.centre[row])) / camera.scales[row], m));
  const numbersAt = (list, from, count) => Array.from({ length: count }, (_, k) => list[from + k] / PARTS);
  const turnedBy = ([w, x, y, z]) => {
    const n = 2 / (w * w + x * x + y * y + z * z || 1);
    return [
      [1 - n * (y * y + z * z), n * (x * y - w * z), n * (x * z + w * y)],
      [n * (x * y + w * z), 1 - n * (x * x + z * z), n * (y * z - w * x)],
      [n * (x * z - w * y), n * (y * z + w * x), 1 - n * (x * x + y * y)],
    ];
  };
  // A point of a part, where its pose puts it; and the reverse.
  const localOf = ({ frames }, part, p) => {
    const rows = turnedBy(numbersAt(frames, 7 * part, 4));
    const from = numbersAt(frames, 7 * part + 4, 3).map((o, k) => p[k] - o);
    return [0, 1, 2].map((k) => rows.reduce((sum, row, i) => sum + row[k] * from[i], 0));
  };
  const placed = ({ frames }, part, p) => {
    const rows = turnedBy(numbersAt(frames, 7 * part, 4));
    const origin = numbersAt(frames, 7 * part + 4, 3);
    return rows.map((row, i) => row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + origin[i]);
  };

  // Where the corners of a layer are in the picture, how near, and how light.
  const place = (layer, camera) => {
    const { mesh, at: [xs, ys, zs, ls], matrices } = layer;
    const nearer = layer.look === "receptors" ? ON_CLOTH * camera.scales[2] : 0;
    const { frames } = poses[layer.poses];
    for (let p = 0; p < mesh.parts; p += 1) {
      const rows = turnedBy(numbersAt(frames, 7 * p, 4));
      const m = EACH * p;
      const onto = (vector, i) => vector[0] * rows[0][i] + vector[1] * rows[1][i] + vector[2] * rows[2][i];
      const origin = project(camera, numbersAt(frames, 7 * p + 4, 3));
      for (let row = 0; row < 3; row += 1) {
        for (let i = 0; i < 3; i += 1) matrices[m + 4 * row + i] = camera.scales[row] * onto(camera.axes[row], i);
        matrices[m + 4 * row + 3] = origin[row];
      }
      for (let i = 0; i < 3; i += 1) matrices[m + 12 + i] = onto(camera.light, i);
    }
    const { part, local, normals } = mesh;
    for (let k = 0, c = 0; k < part.length; k += 1, c += 3) {
      const m = EACH * part[k];
      const x = local[c], y = local[c + 1], z = local[c + 2];
      xs[k] = matrices[m] * x + matrices[m + 1] * y + matrices[m + 2] * z + matrices[m + 3];
      ys[k] = matrices[m + 4] * x + matrices[m + 5] * y + matrices[m + 6] * z + matrices[m + 7];
      zs[k] = matrices[m + 8] * x + matrices[m + 9] * y + matrices[m + 10] * z + matrices[m + 11] + nearer;
      const light = matrices[m + 12] * normals[c] + matrices[m + 13] * normals[c + 1] + matrices[m + 14] * normals[c + 2];
      ls[k] = PAD + (SHADES - 1) * Math.max(0, 0.5 + 0.5 * light);
    }
  };

  // Fills the triangles of a layer that face who looks, row by row, nearest pixels kept.
  const fill = (layer, { width, height, pixels, depth, shown }, values, lit) => {
    const { mesh: { faces, of, limbs }, at: [xs, ys, zs, ls], first } = layer;
    const under = layer.look === "ghost";
    for (let f = 0, t = 0; f < faces.length; f += 3, t += 1) {
      const a = faces[f], b = faces[f + 1], c = faces[f + 2];
      const ax = xs[a], ay = ys[a], bx = xs[b], by = ys[b], cx = xs[c], cy = ys[c];
      const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
      // Rows go down: what faces who looks turns the other way round.
      if (!(area < 0)) continue;
      const top = Math.max(0, Math.ceil(Math.min(ay, by, cy) - 0.5));
      const bottom = Math.min(height - 1, Math.floor(Math.max(ay, by, cy) - 0.5));
      const zx = ((zs[b] - zs[a]) * (cy - ay) - (zs[c] - zs[a]) * (by - ay)) / area;
      const zy = ((zs[c] - zs[a]) * (bx - ax) - (zs[b] - zs[a]) * (cx - ax)) / area;
      const lx = ((ls[b] - ls[a]) * (cy - ay) - (ls[c] - ls[a]) * (by - ay)) / area;
      const ly = ((ls[c] - ls[a]) * (bx - ax) - (ls[b] - ls[a]) * (cx - ax)) / area;
      const ab = (bx - ax) / (by - ay), bc = (cx - bx) / (cy - by), ca = (ax - cx) / (ay - cy);
      const id = first + of[t];
      // What feels nothing is there to be pointed at, and not seen.
      const unseen = layer.lit_alone && !(values[of[t]] > 0);
      const lights = layer.look === "solid" && lit.has(limbs[of[t]]);
      const lut = (lights && lamp) || layer.luts?.[layer.painted[of[t]]] || layer.lut || scale[Math.round(Math.min(Math.max(values[of[t]] || 0, 0), 1) * VALUES)];
      for (let y = top; y <= bottom; y += 1) {
        const row = y + 0.5;
        let left = Infinity, right = -Infinity;
        if ((ay <= row) !== (by <= row)) { const x = ax + (row - ay) * ab; if (x < left) left = x; if (x > right) right = x; }
        if ((by <= row) !== (cy <= row)) { const x = bx + (row - by) * bc; if (x < left) left = x; if (x > right) right = x; }
        if ((cy <= row) !== (ay <= row)) { const x = cx + (row - cy) * ca; if (x < left) left = x; if (x > right) right = x; }
        const from = Math.max(0, Math.ceil(left - 0.5));
        const end = y * width + Math.min(width, Math.ceil(right - 0.5));
        let z = zs[a] + zx * (from + 0.5 - ax) + zy * (row - ay);
        let l = ls[a] + lx * (from + 0.5 - ax) + ly * (row - ay);
        for (let at = y * width + from; at < end; at += 1, z += zx, l += lx) {
          if (z > depth[at] && !(under && shown[at] >= 0 && shown[at] < firstGhost)) {
            depth[at] = z;
            shown[at] = id;
            if (!unseen) pixels[at] = lut[l | 0];
          }
        }
      }
    }
  };

  // Darkens the edge of whatever stands before something farther away.
  const outline = ({ width, height, pixels, depth, shown }, step) => {
    const dark = (x) => (x & 255) * OUTLINE | 0;
    for (let y = 1; y < height - 1; y += 1) {
      for (let at = y * width + 1, end = at + width - 2; at < end; at += 1) {
        if (shown[at] < 0) continue;
        const near = depth[at] - step;
        if (depth[at - 1] < near || depth[at + 1] < near || depth[at - width] < near || depth[at + width] < near) {
          const p = pixels[at];
          pixels[at] = ((p & 0xff000000) | (dark(p >> 16) << 16) | (dark(p >> 8) << 8) | dark(p)) >>> 0;
        }
      }
    }
  };

  // Pictures are kept: a quick one and a sharp one take turns.
  const kept = new Map();
  const cleared = (context, width, height) => {
    const name = `${width} ${height}`;
    if (!kept.has(name)) {
      if (kept.size > 2) kept.clear();
      const image = context.createImageData(width, height);
      const size = width * height;
      const pixels = new Uint32Array(image.data.buffer);
      kept.set(name, { width, height, image, pixels, depth: new Float32Array(size), shown: new Int32Array(size) });
    }
    const picture = kept.get(name);
    picture.pixels.fill(0);
    picture.depth.fill(-Infinity);
    picture.shown.fill(NOTHING);
    return picture;
  };

  return {
    layers,
    project,
    unproject,
    placed,
    localOf,
    cameraOf,
    point: (list, k) => numbersAt(list, 3 * k, 3),
    // A picture of all layers that are shown.
    paint(context, camera, width, height, values, lit) {
      const picture = cleared(context, width, height);
      for (const layer of layers) {
        if (!layer.shown || !poses[layer.poses]) continue;
        place(layer, camera);
        fill(layer, picture, values, lit);
      }
      outline(picture, STEP * camera.scales[0]);
      return picture;
    },
  };
};
