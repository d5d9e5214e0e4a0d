"""Max explores his body, learns it, and reaches by what he learned."""

import tempfile
from pathlib import Path

import bodyschema as bs


def main() -> None:
    creature = bs.Creature("max")
    session = bs.babble(creature, seed=1)
    print(f"{len(session)} touches, {len(session.touches)} columns")

    schema = bs.learn(session)
    print(schema.verdict)
    for limb, reason in schema.unlocated.items():
        print(f"{limb}: {reason}")

    q = creature.sample_postures(1000, seed=2)
    poses = schema.pose("left_hand", q, wrt="head")
    jacobians = schema.jacobian("left_hand", q)
    std = schema.position_std("left_hand", q)
    print(f"poses {poses.shape}, Jacobians {jacobians.shape}, position known to {1e3 * float(std.mean()):.3f} mm on average")

    reach = schema.reach("left_hand", poses[0, :3, 3])
    print(reach.posture if reach.posture is not None else reach.reason)
    print(f"the left hand gets to {schema.reachable('left_hand', voxel=0.05).volume:.1f} m³")

    # The truth enters here and nowhere else.
    print(f"surface error of the located limbs: {bs.evaluate(schema, creature).determined_mm.mean:.6f} mm on average")

    with tempfile.TemporaryDirectory() as folder:
        schema.save(Path(folder) / "learned.xml")
        schema.save(Path(folder) / "learned.urdf")


if __name__ == "__main__":
    main()
