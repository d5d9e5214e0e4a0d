"""Compares the Python package with what its users would write otherwise: `python benches/python.py [MIMO_SCENE.xml]`.

Needs the package, `pip install gymnasium mujoco pin cmeel-eigen`, and g++ for the C++ of Pinocchio. Both sides of a line are
measured in turn in one run, each by the best of several rounds. Given a scene of MIMo, its environment is measured as well.
"""

import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bodyschema as bs
import bodyschema.environment
import numpy as np
import pinocchio

import mujoco

#: Postures whose poses and Jacobians are computed.
POSTURES = 1000
#: The step of the loop that looks for touches, radians of the fastest joint, and how exactly it finds them, as a share of a step.
STEP, EXACT = np.radians(1), 2.0**-20
#: Steps a second of MIMo's own environments at full skin, as its authors' code makes them.
MIMO_STEPS = (141, 367)

PINOCCHIO_CPP = r"""
#include <pinocchio/serialization.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <thread>

int main(int count, char **given) {
    pinocchio::Model model;
    pinocchio::serialization::loadFromText(model, given[1]);
    const int postures = std::stoi(given[3]), threads = std::thread::hardware_concurrency();
    std::vector<pinocchio::FrameIndex> limbs;
    for (int k = 4; k < count; ++k) limbs.push_back(model.getFrameId(given[k]));
    Eigen::MatrixXd q(model.nq, postures);
    std::ifstream(given[2], std::ios::binary).read((char *)q.data(), sizeof(double) * q.size());
    const int size = 16 + 6 * model.nv;
    std::vector<double> all(size_t(size) * limbs.size() * postures);
    auto part = [&](int thread) {
        pinocchio::Data data(model);
        pinocchio::Data::Matrix6x jacobian(6, model.nv);
        for (int k = thread * postures / threads; k < (thread + 1) * postures / threads; ++k) {
            pinocchio::computeJointJacobians(model, data, q.col(k));
            for (size_t limb = 0; limb < limbs.size(); ++limb) {
                double *to = all.data() + size_t(size) * (k * limbs.size() + limb);
                pinocchio::updateFramePlacement(model, data, limbs[limb]);
                Eigen::Map<Eigen::Matrix4d> pose(to);
                pose = data.oMf[limbs[limb]].toHomogeneousMatrix();
                jacobian.setZero();
                pinocchio::getFrameJacobian(model, data, limbs[limb], pinocchio::LOCAL_WORLD_ALIGNED, jacobian);
                Eigen::Map<pinocchio::Data::Matrix6x> kept(to + 16, 6, model.nv);
                kept = jacobian;
            }
        }
    };
    double best = 1e9, sum = 0;
    for (int round = 0; round < 30; ++round) {
        auto begun = std::chrono::steady_clock::now();
        std::vector<std::thread> running;
        for (int thread = 0; thread < threads; ++thread) running.emplace_back(part, thread);
        for (auto &thread : running) thread.join();
        best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
    }
    for (double number : all) sum += number;
    std::printf("%.9f %.12g\n", best, sum);
}
"""


def best(run: Callable[[], object], rounds: int) -> float:
    """The least seconds that it takes."""
    times = []
    for _ in range(rounds):
        begun = time.perf_counter()
        run()
        times.append(time.perf_counter() - begun)
    return min(times)


def show(what: str, ours: float, theirs: float, unit: str) -> None:
    print(f"{what}: {ours:.4g} {unit} against {theirs:.4g}, {max(ours / theirs, theirs / ours):.1f} times", flush=True)


def numpy_kinematics(urdf: Path, names: list[str], limbs: list[str], postures: Any) -> tuple[Any, Any]:
    """Poses (N, L, 4, 4) and Jacobians (N, L, 6, D) of a URDF's links, one after another."""
    joints, carried_by = [], {}
    for joint in ET.parse(urdf).getroot().iter("joint"):
        origin, axis, parent, child = (joint.find(tag) for tag in ("origin", "axis", "parent", "child"))
        vectors = [np.array([float(x) for x in text.split()]) for text in (origin.get("xyz"), axis.get("xyz"))]
        joints.append((names.index(joint.get("name")), parent.get("link"), child.get("link"), *vectors))
        carried_by[child.get("link")] = len(joints) - 1
    chains = {}
    for limb in limbs:
        chain, link = [], limb
        while link in carried_by:
            chain.append(carried_by[link])
            link = joints[chain[-1]][1]
        chains[limb] = chain, [joints[joint][0] for joint in chain]
    poses = np.zeros((len(postures), len(limbs), 4, 4))
    jacobians = np.zeros((len(postures), len(limbs), 6, len(names)))
    for n, q in enumerate(postures):
        links: dict[str, Any] = {limbs[0]: np.eye(4)}
        axes, points = np.zeros((len(joints), 3)), np.zeros((len(joints), 3))
        for number, (column, parent, child, origin, axis) in enumerate(joints):
            x, y, z = axis
            cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            pose = np.eye(4)
            pose[:3, :3] = np.eye(3) + np.sin(q[column]) * cross + (1 - np.cos(q[column])) * cross @ cross
            pose[:3, 3] = origin
            axes[number] = links[parent][:3, :3] @ axis
            points[number] = links[parent][:3, :3] @ origin + links[parent][:3, 3]
            links[child] = links[parent] @ pose
        for k, limb in enumerate(limbs):
            poses[n, k] = links[limb]
            chain, columns = chains[limb]
            jacobians[n, k][:3, columns] = np.cross(axes[chain], links[limb][:3, 3] - points[chain]).T
            jacobians[n, k][3:, columns] = axes[chain].T
    return poses, jacobians


def kinematics() -> None:
    """1,000 postures x all limbs of the learned torso's URDF."""
    creature = bs.Creature("max")
    schema = bs.learn(bs.babble(creature, seed=1))
    limbs, names = creature.limbs, creature.coordinates
    postures = creature.sample_postures(POSTURES, seed=2)
    poses, jacobians = schema.pose(limbs, postures), schema.jacobian(limbs, postures)
    ours = best(lambda: (schema.pose(limbs, postures), schema.jacobian(limbs, postures)), 30)
    with tempfile.TemporaryDirectory() as folder:
        urdf = Path(folder) / "learned.urdf"
        schema.save(urdf)
        found = numpy_kinematics(urdf, names, limbs, postures[:20])
        assert np.allclose(found[0], poses[:20], atol=1e-9) and np.allclose(found[1], jacobians[:20], atol=1e-9)
        theirs = 10 * best(lambda: numpy_kinematics(urdf, names, limbs, postures[::10]), 2)
        show("poses and Jacobians, NumPy loop", ours, theirs, "s")

        model = pinocchio.buildModelFromUrdf(str(urdf))
        data, frames = model.createData(), [model.getFrameId(limb) for limb in limbs]
        order = [names.index(name) for name in list(model.names)[1:]]
        ordered = np.ascontiguousarray(postures[:, order])

        def loop() -> list[Any]:
            out = []
            for q in ordered:
                pinocchio.computeJointJacobians(model, data, q)
                pinocchio.updateFramePlacements(model, data)
                for frame in frames:
                    jacobian = pinocchio.getFrameJacobian(model, data, frame, pinocchio.LOCAL_WORLD_ALIGNED)
                    out.append((data.oMf[frame].homogeneous, jacobian))
            return out

        last = loop()[-1]
        assert np.allclose(last[0], poses[-1, -1], atol=1e-9) and np.allclose(last[1], jacobians[-1, -1][:, order], atol=1e-9)
        show("poses and Jacobians, Pinocchio's Python loop", ours, best(loop, 3), "s")

        prefix = Path(pinocchio.__file__).parents[4]
        source, program, numbers = (Path(folder) / name for name in ("loop.cpp", "loop", "postures"))
        model.saveToText(str(Path(folder) / "model"))
        source.write_text(PINOCCHIO_CPP)
        ordered.tofile(numbers)
        include = [f"-I{prefix / 'include'}", f"-I{prefix / 'include' / 'eigen3'}"]
        libraries = [f"-L{prefix / 'lib'}", f"-Wl,-rpath,{prefix / 'lib'}", "-lpinocchio_default", "-lboost_serialization"]
        subprocess.run(
            [
                "g++",
                "-std=c++17",
                "-O3",
                "-march=native",
                "-DNDEBUG",
                *("-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"),
                *include,
                str(source),
                "-o",
                str(program),
                *libraries,
                "-pthread",
            ],
            check=True,
        )
        command = [str(program), str(Path(folder) / "model"), str(numbers), str(POSTURES), *limbs]
        # In turn, so that other work on the machine disturbs both alike.
        ours = seconds = np.inf
        for _ in range(5):
            ours = min(ours, best(lambda: (schema.pose(limbs, postures), schema.jacobian(limbs, postures)), 30))
            taken, total = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
            seconds = min(seconds, float(taken))
        assert np.isclose(float(total), poses.sum() + jacobians.sum(), rtol=1e-9)
        show("poses and Jacobians, Pinocchio's C++ in threads", ours, seconds, "s")


def mujoco_touches(path: str, names: list[str], count: int) -> int:
    """Goes straight from the middle to random postures; bisection finds where limbs first overlap, until there are so many."""
    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    joints = [model.joint(name).id for name in names]
    moved, ranges = model.jnt_qposadr[joints], model.jnt_range[joints]
    # The limb of a body is the nearest body before it that a joint moves.
    limb = np.arange(model.nbody)
    carriers = {int(model.jnt_bodyid[joint]) for joint in joints}
    for body in range(1, model.nbody):
        if body not in carriers:
            limb[body] = limb[model.body_parentid[body]]
    carrier = limb[model.body_parentid]
    rng, start = np.random.default_rng(1), np.zeros(len(names))

    def touching(posture: Any) -> bool:
        data.qpos[moved] = posture
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        a, b = (limb[model.geom_bodyid[data.contact.geom[:, side]]] for side in (0, 1))
        return bool(((a != b) & (carrier[a] != b) & (carrier[b] != a)).any())

    assert not touching(start)
    made = 0
    while made < count:
        target = rng.uniform(*ranges.T)
        steps = int(np.ceil(np.abs(target - start).max() / STEP))
        hit = next((k for k in range(1, steps + 1) if touching(start + (target - start) * k / steps)), None)
        if hit is None:
            continue
        free, deep = (hit - 1) / steps, hit / steps
        while (deep - free) * steps > EXACT:
            middle = (free + deep) / 2
            free, deep = (free, middle) if touching(start + (target - start) * middle) else (middle, deep)
        made += 1
    return made


def touches() -> None:
    creature = bs.Creature("max")
    ours, theirs = 4000, 200
    mine = ours / best(lambda: bs.babble(creature, touches=ours, policy="random"), 2)
    other = theirs / best(lambda: mujoco_touches(creature.model, creature.coordinates, theirs), 2)
    show("touches, MuJoCo's Python loop with bisection", mine, other, "a second")


def environment(model: str, **options: Any) -> None:
    envs = bodyschema.environment.SelfTouchVector(16, model, **options)
    envs.reset(seed=1)
    envs.action_space.seed(1)
    actions = [envs.action_space.sample() for _ in range(10)]

    begun = time.process_time()
    for action in actions:
        for _ in range(20):
            envs.step(action)
    rate = 16 * 20 * len(actions) / (time.process_time() - begun)
    receptors = len(envs.creature.receptors["id"])
    what = f"environment of {envs.creature.name}, {receptors} receptors, one core, MIMo's own"
    show(what, rate, MIMO_STEPS[1], "steps a second of processor time")


if __name__ == "__main__":
    kinematics()
    touches()
    environment("max")
    if len(sys.argv) > 1:
        begun = time.perf_counter()
        bs.Creature(sys.argv[1], joints="all")
        print(f"{sys.argv[1]} is read in {time.perf_counter() - begun:.1f} s")
        environment(sys.argv[1], joints="all")
