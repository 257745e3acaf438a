"""Which metric for which data: every metric and loss, this library's and its peers', on pairs of a simulated world, whose poses are
known: metrics.py BINARIES OUTPUT [PAIRS].

All start from the identity, once, and end at a step of 0.1 mm and 0.01 degrees or a tenth of the library's own criteria. Writes
OUTPUT/metrics.json, OUTPUT/metrics.md and OUTPUT/metrics.png."""

import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

os.environ.setdefault("OMP_NUM_THREADS", "2")

import matplotlib
import numpy

import peer
from world import WORLDS

matplotlib.use("Agg")
import matplotlib.pyplot as plt

BINARIES, OUTPUT = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
PAIRS = int(sys.argv[3]) if len(sys.argv) > 3 else 34  # of each world
ITERATIONS = 100
METRICS = ["point", "plane", "symmetric", "gicp"]
LOSSES = ["huber", "cauchy", "geman-mcclure", "tukey", "welsch"]
LIMITED = "none, limit"
COLUMNS = ["none", LIMITED, *LOSSES]
STOCK = {"PCL, point": "stock", "PCL, plane": "stock_planes", "PCL, gicp": "stock_gicp"}
PEERS = {"small_gicp, point": "small_gicp ICP", "small_gicp, plane": "small_gicp point-to-plane",
         "small_gicp, gicp": "small_gicp GICP", "Open3D, point": "Open3D ICP", "Open3D, plane": "Open3D point-to-plane"}
LIMIT_IN_SHIFTS = 2  # LIMITED: no pair is farther apart than so many of the largest shifts of the world


def pcd(points):
    return (f"VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {len(points)}\nHEIGHT 1\n"
            f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\nDATA binary\n").encode() + points.tobytes()


def error(transform, truth):
    """Metres, at the sensor, and degrees; infinite without a transform."""
    if transform is None:
        return numpy.inf, numpy.inf
    transform = numpy.array(transform, dtype=float)
    # Of small angles the cosine has no digits.
    turn = numpy.linalg.norm(transform[:3, :3] - truth[:3, :3]) / numpy.sqrt(8)
    return float(numpy.linalg.norm((transform - truth)[:3, 3])), float(numpy.degrees(2 * numpy.arcsin(min(turn, 1))))


def ours(world, pairs, folder):
    """Of each metric and column the transforms of all pairs, of one batch."""
    lines, keys = [], []
    for metric in METRICS:
        for column in COLUMNS:
            for i in range(len(pairs)):
                line = {"source": f"{i}.source.pcd", "target": f"{i}.target.pcd", "metric": metric}
                if column == LIMITED:
                    line["max-distance"] = LIMIT_IN_SHIFTS * world.shift
                else:
                    line["loss"] = column
                lines.append(json.dumps(line))
                keys.append((f"ours, {metric}", column))
    manifest = folder / "pairs.jsonl"
    manifest.write_text("\n".join(lines))
    done = subprocess.run(
        [BINARIES / "src/cli/pcl_gpu_icp", "batch", manifest, "-o", folder / "results", "--once", "--quiet", "--iterations",
         str(ITERATIONS), "--translation-epsilon", "1e-4", "--rotation-epsilon", "0.01"], capture_output=True, text=True)
    if done.returncode > 1:
        raise RuntimeError(done.stderr)
    results = sorted(map(json.loads, (folder / "results/results.jsonl").read_text().splitlines()),
                     key=lambda result: result["pair"])
    transforms = {}
    for key, result in zip(keys, results, strict=True):
        transforms.setdefault(key, []).append(result.get("transform"))
    return transforms


def of_stock(method, files, limit):
    command = [BINARIES / "bench/align_benchmark", method, *files, str(ITERATIONS), "precise", *([str(limit)] if limit else [])]
    done = subprocess.run(command, capture_output=True, text=True)
    return json.loads(done.stdout)["transform"] if done.returncode == 0 else None


def of_peer(align, pair, limit):
    try:
        return align(*(cloud.astype(float) for cloud in (pair.source, pair.target)), ITERATIONS, 1e-4,
                     **({"limit": limit} if limit else {}))[0]
    except RuntimeError:  # no pairs, no answer
        return None


def measure(world):
    pairs = [world.pair(i) for i in range(PAIRS)]
    aligners, transforms = {}, {}
    for name, method in PEERS.items():
        try:
            aligners[name] = peer.METHODS[method]()
        except ImportError as absent:
            print(f"metrics: {name} is absent: {absent}", file=sys.stderr)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for i, pair in enumerate(pairs):
            files = []
            for which in ("source", "target"):
                (folder / f"{i}.{which}.pcd").write_bytes(pcd(getattr(pair, which)))
                files.append(folder / f"{i}.{which}")
                getattr(pair, which).tofile(files[-1])
            for column in ("none", LIMITED):
                limit = LIMIT_IN_SHIFTS * world.shift if column == LIMITED else None
                for method, command in STOCK.items():
                    transforms.setdefault((method, column), []).append(of_stock(command, files, limit))
                for method, align in aligners.items():
                    transforms.setdefault((method, column), []).append(of_peer(align, pair, limit))
        transforms.update(ours(world, pairs, folder))
    transforms["guess", "none"] = [numpy.eye(4)] * len(pairs)
    errors = {key: [error(transform, pair.truth) for transform, pair in zip(found, pairs)] for key, found in transforms.items()}
    print(f"{world.name}: {len(pairs)} pairs of {len(pairs[0].source)} points", file=sys.stderr, flush=True)
    return errors


def is_right(error, world):
    return error[0] <= world.right[0] and error[1] <= world.right[1]


def table(world, errors):
    methods = list(dict.fromkeys(method for method, _ in errors))
    methods.sort(key=lambda method: not method.startswith("ours"))
    limit, right = LIMIT_IN_SHIFTS * world.shift, world.right
    lines = [f"**{world.name}**: right is up to {1e3 * right[0]:.0f} mm and {right[1]} degrees; the limit is {limit:g} m", "",
             "| right, median error | " + " | ".join(COLUMNS) + " |", "|---" * (1 + len(COLUMNS)) + "|"]
    for method in methods:
        cells = []
        for column in COLUMNS:
            found = errors.get((method, column))
            if not found:
                cells.append("")
                continue
            share = 100 * sum(is_right(each, world) for each in found) / len(found)
            shift, turn = (statistics.median(each[i] for each in found) for i in (0, 1))
            cells.append(f"{share:.0f} %, {1e3 * shift:.1f} mm, {turn:.2f}°")
        lines.append(f"| {method} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def best_of(method, errors):
    """The column in which a method's median error of translation is least."""
    columns = [column for each, column in errors if each == method]
    return min(columns, key=lambda column: statistics.median(shift for shift, _ in errors[method, column]))


def plot(results):
    """How many pairs are off by no more than a distance, each method with what serves it best."""
    figure, axes = plt.subplots(1, len(results), figsize=(6 * len(results), 5), sharey=True)
    for axis, (world, errors) in zip(numpy.atleast_1d(axes), results):
        methods = list(dict.fromkeys(method for method, _ in errors))
        for method in methods:
            column = best_of(method, errors)
            shifts = numpy.sort([1e3 * shift for shift, _ in errors[method, column]])
            own = method.startswith("ours")
            axis.step(shifts, 100 * (1 + numpy.arange(len(shifts))) / len(shifts), where="post", linewidth=2 if own else 1,
                      linestyle="-" if own else "--", label=f"{method}, {column}")
        axis.set(xscale="log", xlabel="off by no more than, mm", title=world.name)
        axis.legend(fontsize="x-small")
        axis.grid(alpha=0.3)
    numpy.atleast_1d(axes)[0].set_ylabel("% of the pairs")
    figure.tight_layout()
    figure.savefig(OUTPUT / "metrics.png", dpi=110)


def main():
    OUTPUT.mkdir(parents=True, exist_ok=True)
    results = [(world, measure(world)) for world in WORLDS.values()]
    record = [{"world": world.name, "method": method, "column": column, "metres_and_degrees": found}
              for world, errors in results for (method, column), found in errors.items()]
    (OUTPUT / "metrics.json").write_text(json.dumps(record))
    (OUTPUT / "metrics.md").write_text("\n\n".join(table(*result) for result in results) + "\n")
    plot(results)


if __name__ == "__main__":
    main()
