"""Searches from anywhere, this library's and its peers', on the same pairs: anywhere.py BINARIES SCANS OUTPUT [TRIALS].

Scans are thinned to voxels, the source turned by any rotation and shifted by up to its extent; in full, and as parts that have
half of each in common; for the plot a fifth of the trials with other shares in common. Right is five degrees and two voxels off
at most. Every method is asked one pair after another, in turn; PCL's at every fifth. Writes OUTPUT/anywhere.json, anywhere.md and anywhere.png."""

import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

import matplotlib
import numpy

matplotlib.use("Agg")
import matplotlib.pyplot as plt

BINARIES, SCANS, OUTPUT = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
TRIALS = int(sys.argv[4]) if len(sys.argv) > 4 else 50
OURS, PCL = "ours", "PCL prerejective"
PEERS = [PCL, "KISS-Matcher", "Open3D FGR", "Open3D RANSAC"]
ASKED_EVERY = {PCL: 5}  # trials; it takes seconds
IN_COMMON, ALSO_IN_COMMON = [1, 0.5], [0.9, 0.8, 0.7, 0.6, 0.4, 0.3]
RIGHT_DEGREES, RIGHT_VOXELS = 5, 2


def points_of(file, folder):
    """x, y, z of the finite points of a PCD file that are no zero returns, about the first."""
    raw = folder / "points"
    subprocess.run([BINARIES / "bench/align_benchmark", "points", SCANS / file, raw], check=True)
    points = numpy.fromfile(raw, "f4").reshape(-1, 3).astype(float)
    return points[(points != 0).any(axis=1)]


def scans(source, target, truth=None):
    def clouds(folder):
        pair = [points_of(file, folder) for file in (source, target)]
        if numpy.abs(pair[0]).max() > 1e5:  # where float32 has no digits left
            pair = [cloud - pair[1][0] for cloud in pair]
        return *pair, numpy.loadtxt(SCANS / truth) if truth else numpy.eye(4)

    return clouds


def hippo(folder):
    """One of the two scans that scripts/fetch-hippos writes; doubles."""
    body = (OUTPUT / "hippo1.ply").read_bytes().split(b"end_header\n", 1)[1]
    points = numpy.frombuffer(body, "<f8").reshape(-1, 6)[:, :3]
    return points, points, numpy.eye(4)


def simulated(name):
    def clouds(folder):
        from world import WORLDS

        pair = WORLDS[name].pair(1)
        return pair.source.astype(float), pair.target.astype(float), pair.truth

    return clouds


# Name, voxel size, and what makes source, target and the transform between them.
SCENES = [
    ("lidar_street", 0.3, scans("lidar_street_1.pcd", "lidar_street_0.pcd", "lidar_street_T_0_1.txt")),
    ("rgbd_room", 0.03, scans("rgbd_room_1.pcd", "rgbd_room_0.pcd")),
    ("terrain", 20, scans("terrain_utm.pcd", "terrain_utm.pcd")),
    ("bunny", 0.004, scans("bunny_0.pcd", "bunny_0.pcd")),
    ("hippo", 0.012, hippo),
    ("simulated street", 0.3, simulated("street")),
    ("simulated room", 0.05, simulated("room")),
]


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


def parts(source, target, truth, share, random):
    """Of the clouds what lies on either side along a direction, so that such a share of each is in common."""
    along = random.normal(size=3)
    at_source, at_target = (source @ truth[:3, :3].T + truth[:3, 3]) @ along, target @ along
    kept = 1 / (2 - share)  # of each cloud
    low, high = numpy.quantile(at_target, [1 - kept, kept])
    return source[at_source <= high], target[at_target >= low]


def pair_of(clouds, voxel, share, random):
    source, target, truth = clouds
    source, target = parts(source, target, truth, share, random)
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
        own = {OURS: [], PCL: ["pcl", str(voxel)]}
        command = [BINARIES / "bench/search_benchmark", *own[name]] if name in own else [
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


def measure(scene, clouds, share, trials, folder):
    name, voxel, _ = scene
    random = numpy.random.default_rng(1)
    methods = {method: Method(method, voxel) for method in [OURS, *PEERS]}
    rows = {method: {"right": [], "ms": [], "starts": []} for method in methods}
    files = folder / "source", folder / "target"
    for trial in range(trials + 1):
        source, target, truth = pair_of(clouds, voxel, share, random)
        for cloud, file in zip((source, target), files):
            cloud.astype("f4").tofile(file)
        for method, process in methods.items():
            if trial % ASKED_EVERY.get(method, 1) != 0:
                continue
            answer = process.search(files)
            if answer is None:
                rows.pop(method, None)
            elif trial > 0:  # The first pays for what is made once.
                rows[method]["ms"].append(answer["ms"])
                rows[method]["right"].append(is_right(answer, truth, source, voxel))
                rows[method]["starts"].append(answer.get("starts"))
    for process in methods.values():
        process.end()
    print(f"{name}, {100 * share:.0f} % in common:",
          {m: (sum(r["right"]), round(statistics.median(r["ms"]))) for m, r in rows.items()}, file=sys.stderr, flush=True)
    return {"scene": name, "in_common": share, "points": [len(source), len(target)], "trials": trials, "methods": rows}


def table(results):
    lines = ["| right, median time | " + " | ".join([OURS, *PEERS]) + " |", "|---" * (2 + len(PEERS)) + "|"]
    for result in results:
        cells = []
        for method in [OURS, *PEERS]:
            row = result["methods"].get(method)
            cells.append(f"{100 * statistics.mean(row['right']):.0f} %, {statistics.median(row['ms']):.0f} ms" if row else "absent")
        name = result["scene"] + ("" if result["in_common"] == 1 else f", {100 * result['in_common']:.0f} % in common")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def plot(results):
    """Over what is in common, all scenes together: how often right, how long it took; and our own over the starts taken."""
    figure, (success, time, starts) = plt.subplots(1, 3, figsize=(18, 5))
    shares = sorted({result["in_common"] for result in results})
    for method in [OURS, *PEERS]:
        rows = [[result["methods"][method] for result in results if result["in_common"] == share and method in result["methods"]]
                for share in shares]
        if not all(rows):
            continue
        style = {"linewidth": 2.5 if method == OURS else 1.2, "marker": "o", "label": method}
        success.plot([100 * share for share in shares],
                     [100 * numpy.mean([each for row in of for each in row["right"]]) for of in rows], **style)
        time.plot([100 * share for share in shares],
                  [numpy.median([each for row in of for each in row["ms"]]) for of in rows], **style)
    success.set(xlabel="% of each cloud in common", ylabel="% right", title="success")
    time.set(xlabel="% of each cloud in common", ylabel="ms", yscale="log", title="median time")
    own = [result["methods"][OURS] for result in results if OURS in result["methods"]]
    taken, right, ms = (numpy.array([each for row in own for each in row[what]]) for what in ("starts", "right", "ms"))
    for is_right_, colour, label in ((True, "tab:green", "right"), (False, "tab:red", "not right")):
        starts.scatter(taken[right == is_right_], ms[right == is_right_], s=8, alpha=0.5, color=colour, label=label)
    starts.set(xscale="log", yscale="log", xlabel="starts that were tried", ylabel="ms", title="ours, each search")
    for axis in (success, time, starts):
        axis.legend(fontsize="small")
        axis.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(OUTPUT / "anywhere.png", dpi=90)


def main():
    OUTPUT.mkdir(parents=True, exist_ok=True)
    results, others = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for scene in SCENES:
            try:
                clouds = scene[2](folder)
            except (ImportError, FileNotFoundError) as absent:
                print(f"anywhere: {scene[0]} is absent: {absent}", file=sys.stderr)
                continue
            results += [measure(scene, clouds, share, TRIALS, folder) for share in IN_COMMON]
            others += [measure(scene, clouds, share, max(TRIALS // 5, 5), folder) for share in ALSO_IN_COMMON]
    (OUTPUT / "anywhere.json").write_text(json.dumps(results + others))
    (OUTPUT / "anywhere.md").write_text(table(results) + "\n")
    plot(results + others)


if __name__ == "__main__":
    main()
