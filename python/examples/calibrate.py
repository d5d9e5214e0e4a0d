"""A robot whose encoder offsets are wrong is calibrated by a log of its self-contacts."""

from pathlib import Path

import bodyschema as bs

ROBOT = Path(__file__).parents[2] / "examples" / "robot"


def main() -> None:
    robot = bs.Robot(ROBOT / "arms.urdf")
    fit = bs.calibrate(robot, ROBOT / "touches.csv", free=["*.offset"], held_out=0.3)
    print(fit.verdict)
    for name, change in zip(fit.quantities["name"], fit.quantities["change"], strict=True):
        print(f"{name}: {change:.4f} rad")
    if fit.held_out is not None:
        print(f"held-out touches are {1e3 * fit.held_out.rms:.3f} mm apart")


if __name__ == "__main__":
    main()
