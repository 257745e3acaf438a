"""Searches from anywhere, this library's and its peers', on the same pairs: anywhere.py BINARIES SCANS OUTPUT [TRIALS].

Scans are thinned to voxels, the source turned by any rotation and shifted by up to its extent; in full, and as parts that have
half of each in common. Right is five degrees and two voxels off at most. Every method is asked one pair after another, in
turn. Writes OUTPUT/anywhere.json and OUTPUT/anywhere.md."""

import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

import numpy

BINARIES, SCANS, OUTPUT = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
TRIALS = int(sys.argv[4]) if len(sys.argv) > 4 else 50
OURS = "ours"
PEERS = ["KISS-Matcher", "Open3D FGR", "Open3D RANSAC"]

# Name, source, target, file of the transform from source to target or none where they are at one place, voxel size.
SCENES = [
    ("lidar_street", "lidar_street_1.pcd", "lidar_street_0.pcd", "lidar_street_T_0_1.txt", 0.3),
    ("rgbd_room", "rgbd_room_1.pcd", "rgbd_room_0.pcd", None, 0.03),
    ("terrain", "terrain_utm.pcd", "terrain_utm.pcd", None, 20),
    ("bunny", "bunny_0.pcd", "bunny_0.pcd", None, 0.004),
]
RIGHT_DEGREES, RIGHT_VOXELS = 5, 2


def points_of(file, folder):
    """x, y, z of the finite points of a PCD file that are no zero returns, about the first."""
    raw = folder / "points"
    subprocess.run([BINARIES / "bench/align_benchmark", "points", SCANS / file, raw], check=True)
    points = numpy.fromfile(raw, "f4").reshape(-1, 3).astype(float)
    return points[(points != 0).any(axis=1)]


def thinned(points, size):
    """Of each voxel the point that comes first."""
    _, first = numpy.unique(numpy.floor(points / size).astype(numpy.int64), axis=0, return_index=True)
    return points[first]


def any_rotation(random):
    quaternion = random.normal(size=4)
    w, x, y, z = quaternion / numpy.linalg.norm(quaternion)
    return numpy.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


def halves(source, target, truth, random):
    """What lies below two thirds along a direction, and above one third: half of each is in common."""
    along = random.normal(size=3)
    at_source, at_target = (source @ truth[:3, :3].T + truth[:3, 3]) @ along, target @ along
    low, high = numpy.quantile(at_target, [1 / 3, 2 / 3])
    return source[at_source < high], target[at_target > low]


def pair_of(scene, clouds, is_half, random):
    _, _, _, _, voxel = scene
    source, target, truth = clouds
    if is_half:
        source, target = halves(source, target, truth, random)
    # Other points of each, where both are one scan.
    source, target = (thinned(cloud[random.random(len(cloud)) < 0.8], voxel) for cloud in (source, target))
    away = numpy.eye(4)
    away[:3, :3] = any_rotation(random)
    extent = numpy.linalg.norm(numpy.ptp(source, axis=0))
    away[:3, 3] = random.uniform(-extent, extent, 3) / numpy.sqrt(3)
    return source @ away[:3, :3].T + away[:3, 3], target, truth @ numpy.linalg.inv(away)


class Method:
    """A process that answers one pair after another."""

    def __init__(self, name, voxel):
        command = [BINARIES / "bench/search_benchmark"] if name == OURS else [
            sys.executable, pathlib.Path(__file__).with_name("search_peer.py"), name, str(voxel)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.DEVNULL, text=True)

    def search(self, files):
        """None where the method is absent."""
        try:
            print(*files, file=self.process.stdin, flush=True)
            while line := self.process.stdout.readline():
                if line.startswith("{"):
                    return json.loads(line)
        except BrokenPipeError:
            pass
        return None

    def end(self):
        self.process.kill()
        self.process.wait()


def is_right(answer, truth, source, voxel):
    if "transform" not in answer:
        return False
    transform = numpy.array(answer["transform"])
    turn = numpy.clip((numpy.trace(transform[:3, :3].T @ truth[:3, :3]) - 1) / 2, -1, 1)
    centre = source.mean(axis=0)
    off = numpy.linalg.norm((transform - truth)[:3, :3] @ centre + (transform - truth)[:3, 3])
    return bool(numpy.degrees(numpy.arccos(turn)) <= RIGHT_DEGREES and off <= RIGHT_VOXELS * voxel)


def measure(scene, is_half, folder):
    name, source_file, target_file, truth_file, voxel = scene
    random = numpy.random.default_rng(1)
    clouds = [points_of(file, folder) for file in (source_file, target_file)]
    if numpy.abs(clouds[0]).max() > 1e5:  # where float32 has no digits left
        clouds = [cloud - clouds[1][0] for cloud in clouds]
    clouds.append(numpy.loadtxt(SCANS / truth_file) if truth_file else numpy.eye(4))
    methods = {method: Method(method, voxel) for method in [OURS, *PEERS]}
    rows = {method: {"right": 0, "ms": []} for method in methods}
    files = folder / "source", folder / "target"
    for trial in range(TRIALS + 1):
        source, target, truth = pair_of(scene, clouds, is_half, random)
        for cloud, file in zip((source, target), files):
            cloud.astype("f4").tofile(file)
        for method, process in methods.items():
            answer = process.search(files)
            if answer is None:
                rows.pop(method, None)
            elif trial > 0:  # The first pays for what is made once.
                rows[method]["ms"].append(answer["ms"])
                rows[method]["right"] += is_right(answer, truth, source, voxel)
    for process in methods.values():
        process.end()
    print(f"{name}{', half' if is_half else ''}:", {m: (r["right"], round(statistics.median(r["ms"])))
                                                  for m, r in rows.items()}, file=sys.stderr, flush=True)
    return {"scene": name, "half": is_half, "points": [len(source), len(target)], "trials": TRIALS, "methods": rows}


def main():
    OUTPUT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        results = [measure(scene, is_half, pathlib.Path(folder)) for scene in SCENES for is_half in (False, True)]
    (OUTPUT / "anywhere.json").write_text(json.dumps(results, indent=1))
    lines = ["| right, median time | " + " | ".join([OURS, *PEERS]) + " |", "|---" * (2 + len(PEERS)) + "|"]
    for result in results:
        cells = []
        for method in [OURS, *PEERS]:
            row = result["methods"].get(method)
            cells.append(f"{100 * row['right'] / TRIALS:.0f} %, {statistics.median(row['ms']):.0f} ms" if row else "absent")
        lines.append(f"| {result['scene']}{', half' if result['half'] else ''} | " + " | ".join(cells) + " |")
    (OUTPUT / "anywhere.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
