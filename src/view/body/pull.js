// Forward and inverse kinematics of the schema in a page: where limbs are in a posture, and the posture that brings a point of a
// limb to a place, by damped least squares within the ranges of the joints.
//
// `joints` is the learned schema: joint i carries limb i + 1. `size` is a length of the body, metres. A posture is a list of
// coordinates in the order of the joints: radians, metres, and of a ball a quaternion w x y z.
const Kinematics = (joints, size) => {
  // Damping, the longest step of the point, and the tolerance, as shares of the size; and the most steps.
  const DAMPING = 0.04;
  const STEP = 0.12;
  const REACHED = 0.002;
  const ROUNDS = 40;
  // Improvements below this share end the search.
  const STALLED = 1e-4;

  const plus = (a, b, share = 1) => [a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const times = ([aw, ...a], [bw, ...b]) => [aw * bw - dot(a, b), ...plus(plus(cross(a, b), b, aw), a, bw)];
  const turned = ([w, ...v], p) => {
    const t = cross(v, p);
    return plus(plus(p, t, 2 * w), cross(v, t), 2);
  };
  const about = (axis, angle) => [Math.cos(angle / 2), ...axis.map((x) => x * Math.sin(angle / 2))];
  const unit = (v) => v.map((x) => x / (Math.hypot(...v) || 1));
  const metres = (list) => list.map((x) => x / PARTS);

  // Degrees of freedom, each with the place of its coordinates; and joints with the poses of limbs on them.
  const dofs = [];
  let coordinates = 0;
  const chain = joints.map(({ parent, at, dofs: own, pose }) => ({
    parent,
    at: metres(at),
    pose: pose && { q: unit(pose.slice(0, 4)), o: metres(pose.slice(4)) },
    dofs: own.map((dof) => {
      const made = { ...dof, axis: unit(dof.axis), coordinate: coordinates };
      coordinates += dof.kind === "ball" ? 4 : 1;
      dofs.push(made);
      return made;
    }),
  }));
  const within = ({ range: [low, high] }, x) => Math.min(Math.max(x, low), high);
  // A ball turned no farther than its greatest angle.
  const ballWithin = ({ range: [, most] }, q) => {
    const [w, ...v] = unit(q[0] < 0 ? q.map((x) => -x) : q);
    const angle = 2 * Math.atan2(Math.hypot(...v), w);
    return angle > most ? about(unit(v), most) : [w, ...v];
  };
  // The same posture with every coordinate within its range and followers where their leaders put them.
  const allowed = (posture) => {
    const next = [...posture];
    for (const dof of dofs) {
      const at = dof.coordinate;
      if (dof.kind === "ball") next.splice(at, 4, ...ballWithin(dof, next.slice(at, at + 4)));
      else next[at] = within(dof, next[at]);
    }
    for (const { coordinate, follows } of dofs) {
      if (follows) next[coordinate] = follows.polynomial.reduceRight((sum, c) => sum * next[dofs[follows.leader].coordinate] + c, 0);
    }
    return next;
  };
  // The rest posture, or the nearest to it within the ranges.
  const rest = allowed(dofs.flatMap(({ kind }) => (kind === "ball" ? [1, 0, 0, 0] : [0])));

  // Carries the frame of a joint's parent to the limb beyond it; `visit` sees each degree of freedom with the frame before it.
  const carry = ({ at, dofs: own, pose }, posture, frame, visit = () => {}) => {
    let [q, o] = [frame.q, plus(frame.o, turned(frame.q, at))];
    for (const dof of own) {
      visit(dof, { q, o });
      const x = posture[dof.coordinate];
      if (dof.kind === "slide") o = plus(o, turned(q, dof.axis), x);
      else q = times(q, dof.kind === "ball" ? posture.slice(dof.coordinate, dof.coordinate + 4) : about(dof.axis, x));
    }
    return pose ? { q: times(q, pose.q), o: plus(o, turned(q, pose.o)) } : { q, o };
  };
  const root = { q: [1, 0, 0, 0], o: [0, 0, 0] };
  const framesOf = (posture) => {
    const frames = [root];
    for (const joint of chain) frames.push(carry(joint, posture, frames[joint.parent]));
    return frames;
  };
  const pathTo = (limb) => (limb === 0 ? [] : [...pathTo(chain[limb - 1].parent), chain[limb - 1]]);
  const placeOf = (posture, limb, local) => {
    const frame = pathTo(limb).reduce((at, joint) => carry(joint, posture, at), root);
    return plus(frame.o, turned(frame.q, local));
  };

  // Slides count in sizes, turns in radians: both then move a point about as far.
  const unitOf = ({ kind }) => (kind === "slide" ? size : 1);
  // How a point of a limb moves: per free degree of freedom a column for each of its directions.
  const columnsOf = (posture, path, local) => {
    const seen = [];
    const end = path.reduce((at, joint) => carry(joint, posture, at, (dof, before) => seen.push([dof, before])), root);
    const p = plus(end.o, turned(end.q, local));
    const free = new Map();
    for (const [dof, { q, o }] of seen) {
      const axes = dof.kind === "ball" ? [[1, 0, 0], [0, 1, 0], [0, 0, 1]] : [dof.axis];
      const moved = (axis) => (dof.kind === "slide" ? turned(q, axis) : cross(turned(q, axis), plus(p, o, -1)));
      // A follower adds what it moves to its leader, per unit of that.
      const leader = dof.follows ? dofs[dof.follows.leader] : dof;
      const x = posture[leader.coordinate];
      const rate = dof.follows ? dof.follows.polynomial.reduceRight((sum, c, k) => (k ? sum * x + k * c : sum), 0) : 1;
      const before = free.get(leader) || axes.map(() => [0, 0, 0]);
      free.set(leader, axes.map((axis, k) => plus(before[k], moved(axis), rate * unitOf(leader))));
    }
    return { p, free };
  };
  // Solves a symmetric system of three by Cramer's rule.
  const solved = (rows, b) => {
    const [x, y, z] = rows;
    const whole = dot(x, cross(y, z));
    return [dot(b, cross(y, z)), dot(x, cross(b, z)), dot(x, cross(y, b))].map((d) => d / whole);
  };
  // A step towards a place; what is at the end of its range and would leave it is held.
  const stepped = (posture, free, error) => {
    const held = new Set();
    for (;;) {
      const moving = [...free].filter(([dof]) => !held.has(dof));
      const rows = [0, 1, 2].map((i) => [0, 1, 2].map((k) => (i === k ? (DAMPING * size) ** 2 : 0)));
      for (const column of moving.flatMap(([, columns]) => columns)) {
        for (let i = 0; i < 3; i += 1) for (let k = 0; k < 3; k += 1) rows[i][k] += column[i] * column[k];
      }
      const force = solved(rows, error);
      const steps = moving.map(([dof, columns]) => [dof, columns.map((column) => unitOf(dof) * dot(column, force))]);
      const leaving = steps.filter(([dof, [by]]) => {
        const [low, high] = dof.range;
        const x = posture[dof.coordinate];
        return dof.kind !== "ball" && ((x <= low && by < 0) || (x >= high && by > 0));
      });
      if (leaving.length > 0) {
        leaving.forEach(([dof]) => held.add(dof));
        continue;
      }
      const next = [...posture];
      for (const [dof, by] of steps) {
        const at = dof.coordinate;
        if (dof.kind !== "ball") next[at] += by[0];
        else next.splice(at, 4, ...times(about(unit(by), Math.hypot(...by)), posture.slice(at, at + 4)));
      }
      return allowed(next);
    }
  };

  return {
    rest,
    allowed,
    dofs,
    placeOf,
    // Whether a limb can be moved at all.
    moves: (limb) => pathTo(limb).some(({ dofs: own }) => own.some(({ range: [low, high] }) => high > low)),
    // The posture nearest to a place that was found, and how far off the point of the limb is there, metres.
    pull(posture, limb, local, place) {
      const path = pathTo(limb);
      let now = allowed(posture);
      let best = { posture: now, off: Infinity };
      let stalled = 0;
      for (let round = 0; round < ROUNDS && stalled < 4; round += 1) {
        const { p, free } = columnsOf(now, path, local);
        const error = plus(place, p, -1);
        const off = Math.hypot(...error);
        stalled = off < best.off * (1 - STALLED) ? 0 : stalled + 1;
        if (off < best.off) best = { posture: now, off };
        if (off < STALLED * size) break;
        now = stepped(now, free, error.map((x) => x * Math.min(1, STEP * size / off)));
      }
      return { ...best, reached: best.off <= REACHED * size };
    },
    // Where limbs are in a posture, as a page has poses.
    pose(posture) {
      const frames = framesOf(posture);
      const begins = [root.o, ...chain.map(({ parent, at }) => plus(frames[parent].o, turned(frames[parent].q, at)))];
      return {
        frames: frames.flatMap(({ q, o }) => [...q, ...o].map((x) => x * PARTS)),
        begins: begins.flat().map((x) => x * PARTS),
      };
    },
  };
};
