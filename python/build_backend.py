"""Builds the package by maturin, with pip's MuJoCo and libclang where no others are named, and puts MuJoCo's library into it.

Variables: MUJOCO_DIR names another MuJoCo, or the system's if it is empty; LIBCLANG_PATH another libclang; MATURIN_PEP517_ARGS
holds more arguments for maturin.
"""

import importlib.util
import os
import pathlib
import shutil
import subprocess

import maturin
from maturin import get_requires_for_build_editable, get_requires_for_build_sdist, get_requires_for_build_wheel

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_wheel",
]

PYTHON = pathlib.Path(__file__).resolve().parent
#: The creature that comes with the package, in the repository and in the package.
MODEL, PACKAGED = PYTHON.parent / "mjcf" / "max", PYTHON / "bodyschema" / "models" / "max"

prepare_metadata_for_build_wheel = maturin.prepare_metadata_for_build_wheel
build_sdist = maturin.build_sdist


def _folder_of(package: str) -> pathlib.Path | None:
    """The folder of a package that is installed, which is not imported."""
    spec = importlib.util.find_spec(package)
    places = spec.submodule_search_locations if spec else None
    return pathlib.Path(places[0]) if places else None


def _prepare() -> None:
    """Sets what the build needs, and puts the creature into the package."""
    mujoco, clang = _folder_of("mujoco"), _folder_of("clang")
    if "MUJOCO_DIR" not in os.environ and mujoco:
        os.environ["MUJOCO_DIR"] = str(mujoco)
    if "LIBCLANG_PATH" not in os.environ and clang and (clang / "native").is_dir():
        os.environ["LIBCLANG_PATH"] = str(clang / "native")
        # The package of libclang lacks the headers that belong to a compiler; those of the C compiler do.
        include = subprocess.run(["cc", "-print-file-name=include"], capture_output=True, text=True, check=True).stdout.strip()
        os.environ.setdefault("BINDGEN_EXTRA_CLANG_ARGS", f"-isystem {include}")
    arguments = os.environ.get("MATURIN_PEP517_ARGS", "") + " --auditwheel repair"
    if "--compatibility" not in arguments:
        # Without a value the tag is that of the oldest systems that the wheel runs on.
        arguments += " --compatibility"
    os.environ["MATURIN_PEP517_ARGS"] = arguments.strip()
    shutil.rmtree(PACKAGED, ignore_errors=True)
    shutil.copytree(MODEL, PACKAGED, ignore=shutil.ignore_patterns("*.md"))


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):  # type: ignore[no-untyped-def]
    """A wheel that holds MuJoCo's library under a name of its own, which keeps it apart from that of an imported mujoco."""
    _prepare()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):  # type: ignore[no-untyped-def]
    """The same for work on the package itself: `pip install -e .`."""
    _prepare()
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)
