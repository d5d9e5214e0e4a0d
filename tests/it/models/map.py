"""Makes map.json: an arm's touches with noise, what is nearly known of its joints, and the estimate of greatest posterior by SciPy.

The objective is 3 N/2 log(sigma^2) + sum |r|^2 / (2 sigma^2) + sum of squared differences over squared deviations / 2, with unit axes and
the difference of axes as vectors; sigma is found with the rest. Run: python3 map.py > map.json
"""

import json

import numpy as np
from scipy.optimize import least_squares

rng = np.random.default_rng(20)
names = ["yaw", "pitch", "elbow"]
positions = np.array([[0.0, 0.0, 0.1], [0.02, -0.05, 0.0], [0.2, 0.01, 0.02]])
axes = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.96, 0.28]])
POSITION, AXIS, NOISE, ROWS = 0.01, 0.05, 0.003, 600


def turn(axis, angle):
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def carried(p, a, q, point):
    for j in (2, 1, 0):
        point = p[j] + turn(a[j], q[j]) @ point
    return point


postures = rng.uniform(-1.2, 1.2, (ROWS, 3))
tips = rng.uniform([0.1, -0.02, -0.02], [0.18, 0.02, 0.02], (ROWS, 3))
bases = np.array([carried(positions, axes, q, t) for q, t in zip(postures, tips)]) + NOISE * rng.standard_normal((ROWS, 3))
near = positions + POSITION * rng.standard_normal((3, 3))
near_axes = axes + AXIS * rng.standard_normal((3, 3))
near_axes /= np.linalg.norm(near_axes, axis=1)[:, None]


def parts(x):
    p, a = x[:9].reshape(3, 3), x[9:].reshape(3, 3)
    return p, a / np.linalg.norm(a, axis=1)[:, None]


def apart(x):
    p, a = parts(x)
    return np.array([carried(p, a, q, t) for q, t in zip(postures, tips)]) - bases


def residuals(x, sigma):
    p, a = parts(x)
    # The length of an axis is of no matter: it is held at one.
    lengths = np.linalg.norm(x[9:].reshape(3, 3), axis=1) - 1
    known = [(p - near).ravel() / POSITION, (a - near_axes).ravel() / AXIS, lengths]
    return np.concatenate([apart(x).ravel() / sigma, *known])


x, sigma = np.concatenate([near.ravel(), near_axes.ravel()]), NOISE
for _ in range(20):
    x = least_squares(residuals, x, args=(sigma,), xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    sigma = np.sqrt(np.mean(apart(x) ** 2))

p, a = parts(x)
limbs = ["base", "shoulder", "upper_arm", "forearm"]
joint = lambda j: {"name": f"j_{names[j]}", "parent": limbs[j], "dofs": [{"name": names[j], "kind": "hinge", "range": [-2, 2]}]}
robot = {"name": "arm", "limbs": limbs, "joints": [joint(j) for j in range(3)]}
known = {
    "joints": [
        {
            "joint": f"j_{names[j]}",
            "position": near[j].tolist(),
            "position_std": POSITION,
            "axes": [{"dof": names[j], "axis": near_axes[j].tolist(), "axis_std": AXIS}],
        }
        for j in range(3)
    ]
}
rows = ["limb_a,limb_b,ax,ay,az,bx,by,bz," + ",".join(names)]
for base, tip, q in zip(bases, tips, postures):
    rows.append("base,forearm," + ",".join(repr(float(v)) for v in [*base, *tip, *q]))
found = {}
for j in range(3):
    found[f"j_{names[j]}.position"] = p[j].tolist()
    found[f"{names[j]}.axis"] = a[j].tolist()
print(json.dumps({"robot": robot, "known": known, "noise": float(sigma), "map": found, "log": "\n".join(rows) + "\n"}))
