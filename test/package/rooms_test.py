#!/usr/bin/env python3
"""Checks by the #include lines that every room of the source tree knows only the rooms before it."""

import pathlib
import re
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# A room may include itself and the rooms named here.
MAY_INCLUDE = {
    "kernels": [],
    "values": [],  # public headers of plain types, used by every room
    "geometry": ["values"],
    "host": ["values"],
    "opencl": ["kernels", "values"],
    "search": ["kernels", "values", "geometry", "host"],
    "stages": ["kernels", "values", "geometry", "host", "opencl", "search"],
    "scheduler": ["values"],
    "engine": ["kernels", "values", "geometry", "opencl", "stages", "scheduler", "search"],
    "pcl": ["values", "search", "engine"],
    "instances": ["pcl"],
    "report": ["values", "pcl"],
    "view": ["values", "search", "report"],
    "cli": ["values", "search", "engine", "pcl", "report", "view"],
}

# Public headers that are more than plain types. A header that includes <pcl/...> is in the room "pcl".
HEADER_ROOMS = {
    "rigid_estimator.h": "engine",
    "matcher.h": "engine",
    "neighbour_search.h": "engine",
    "normal_estimator.h": "engine",
    "plane_estimator.h": "engine",
    "point_covariances.h": "engine",
    "icp_loop.h": "engine",
    "device_lane.h": "engine",
    "batch_lanes.h": "engine",
    "matrix.h": "pcl",
}

PCL_ROOMS = {"pcl", "instances", "report", "cli"}
CL_HEADER = "src/opencl/cl.h"
GENERATED = {"embedded_kernels.h": "opencl", "embedded_page.h": "view"}

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)


def includes_of(file):
    return INCLUDE.findall(file.read_text())


def room_of(root, file):
    parts = file.relative_to(root).parts
    if parts[0] == "kernels":
        return "kernels"
    if parts[0] == "src":
        return parts[1]
    if parts[2] == "impl" or any(name.startswith("pcl/") for _, name in includes_of(file)):
        return "pcl"
    if parts[2] == "search":
        return "search"
    return HEADER_ROOMS.get(file.name, "values")


def resolve(root, file, name):
    """The file of this tree that an include means, or None for a header of the system's."""
    for directory in (file.parent, root / "include", root / "src", root):
        candidate = directory / name
        if candidate.is_file():
            return candidate.resolve()
    return None


def violations(root):
    root = root.resolve()
    found = []
    files = [f for folder in ("kernels", "include", "src") for f in sorted((root / folder).rglob("*"))]
    for file in files:
        if file.suffix not in {".h", ".hpp", ".cpp", ".cl"}:
            continue
        room = room_of(root, file)
        where = file.relative_to(root).as_posix()
        if room not in MAY_INCLUDE:
            found.append(f"{where}: the room '{room}' has no place in the order")
            continue
        for quote, name in includes_of(file):
            wrong = None
            target = resolve(root, file, name)
            if target is not None:
                other = room_of(root, target)
                if other != room and other not in MAY_INCLUDE[room]:
                    wrong = f"the room '{room}' may not know '{other}'"
                elif target == root / CL_HEADER and room != "opencl":
                    wrong = "only the room 'opencl' includes cl.h directly"
            elif quote == '"' or name.startswith("pcl_gpu_icp/"):
                # pcl_gpu_icp/version.h is generated too, from cmake/version.h.in.
                if GENERATED.get(name) != room and name != "pcl_gpu_icp/version.h":
                    wrong = "no such file"
            elif name.startswith("CL/") and where != CL_HEADER:
                wrong = f"only {CL_HEADER} includes OpenCL's headers"
            elif name.startswith(("pcl/", "Eigen/")) and room not in PCL_ROOMS:
                wrong = f"the room '{room}' knows neither PCL nor Eigen"
            if wrong:
                found.append(f"{where} includes {name}: {wrong}")
    return found


class Rooms(unittest.TestCase):
    def test_every_room_knows_only_those_before_it(self):
        self.assertEqual(violations(ROOT), [])

    def test_a_violation_is_found(self):
        broken = {
            "src/opencl/early.cpp": '#include "stages/late.h"',
            "src/stages/late.h": "#include <Eigen/Core>",
            "src/stages/direct.cpp": '#include "opencl/cl.h"',
            "src/stages/raw.cpp": "#include <CL/cl.h>",
            "src/opencl/cl.h": "#include <CL/opencl.hpp>",
            "src/engine/host.cpp": "#include <pcl/point_types.h>",
            "src/search/up.cpp": "#include <pcl_gpu_icp/rigid_estimator.h>",
            "src/scheduler/down.cpp": '#include "opencl/cl.h"',
            "src/report/up.cpp": '#include "cli/main.h"',
            "src/cli/main.h": '#include "stages/late.h"',
            "src/attic/file.cpp": "",
            "src/cli/lost.cpp": '#include "nowhere.h"',
            "include/pcl_gpu_icp/rigid_estimator.h": "",
            "include/pcl_gpu_icp/result.h": "#include <pcl_gpu_icp/rigid_estimator.h>",
        }
        fine = {"src/opencl/cl.h", "include/pcl_gpu_icp/rigid_estimator.h"}
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, text in broken.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text + "\n")
            found = violations(root)
        self.assertEqual({re.split("[ :]", line)[0] for line in found}, set(broken) - fine)


if __name__ == "__main__":
    sys.exit(unittest.main())
