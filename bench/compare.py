"""Runs every method on every pair of scans, interleaved, a process each: compare.py BINARIES SCANS OUTPUT [generalized].

Then aligns generated surfaces of growing size. Writes OUTPUT/compare.json with every run but those of Generalized ICP,
OUTPUT/compare.md with the tables of BENCHMARK.md, and OUTPUT/compare.png. With `generalized` it makes the tables of
Generalized ICP alone, OUTPUT/generalized.md."""

import datetime
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile

import matplotlib
import numpy
from scipy.spatial import cKDTree

matplotlib.use("Agg")
import matplotlib.pyplot as plt

BINARIES, SCANS, OUTPUT = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
OURS = {"stock PCL": "stock", "ours, default": "pcl", "ours, device": "device"}
OTHER_PATHS = {"ours, device, Anderson": "accelerated", "ours, device, point-to-plane": "planes"}
GENERALIZED = {"stock PCL GICP": "stock_gicp", "ours, device, GICP": "gicp"}
PEERS = ["small_gicp ICP", "Open3D ICP"]
PEERS_TO_CONVERGENCE = PEERS + ["small_gicp point-to-plane", "small_gicp GICP", "Open3D point-to-plane"]
PEERS_GENERALIZED = ["small_gicp GICP"]
ITERATIONS, ITERATIONS_AT_MOST = 30, 200
SIZES, GROWTH_ITERATIONS = [10_000, 100_000, 1_000_000, 4_000_000], 10

# Name, source, target, voxel size in metres, whether zero returns are left out, runs.
PAIRS = [
    ("street, 0.25 m voxels", "lidar_street_1.pcd", "lidar_street_0.pcd", 0.25, True, 9),
    ("street, no zero returns", "lidar_street_1.pcd", "lidar_street_0.pcd", 0, True, 5),
    ("street, raw", "lidar_street_1.pcd", "lidar_street_0.pcd", 0, False, 3),
    ("rgbd_room", "rgbd_room_1.pcd", "rgbd_room_0.pcd", 0, False, 3),
]
REFERENCES = {"lidar_street_1.pcd": "lidar_street_T_0_1.txt"}  # of a source


def points_of(file, folder):
    """x, y, z of the finite points of a PCD file."""
    raw = folder / "points"
    subprocess.run([BINARIES / "bench/align_benchmark", "points", file, raw], check=True)
    return numpy.fromfile(raw, "f4").reshape(-1, 3)


def voxel_means(points, size):
    keys = numpy.floor(points / size).astype(numpy.int64)
    _, voxel, counts = numpy.unique(keys, axis=0, return_inverse=True, return_counts=True)
    sums = numpy.zeros((len(counts), 3))
    numpy.add.at(sums, voxel.ravel(), points)
    return (sums / counts[:, None]).astype("f4")


def prepared(file, voxel, no_zero_returns, folder):
    points = points_of(SCANS / file, folder)
    if no_zero_returns:
        points = points[(points != 0).any(axis=1)]
    return voxel_means(points, voxel) if voxel else points


def run(method, files, iterations, mode=None):
    own = (OURS | OTHER_PATHS | GENERALIZED).get(method)
    command = [str(BINARIES / "bench/align_benchmark"), own] if own else [
        sys.executable, str(pathlib.Path(__file__).with_name("peer.py")), method]
    command += [*map(str, files), str(iterations)] + ([mode] if mode else [])
    # Threads stay on cores of their own: some kernels wake them all on one.
    bound = {"POCL_AFFINITY": "1"} if own else {"OMP_PROC_BIND": "true"}
    environment = {**bound, **os.environ, "OMP_NUM_THREADS": "2"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    if done.returncode != 0:
        raise RuntimeError(done.stderr.strip().splitlines()[-1])
    return json.loads(done.stdout.splitlines()[-1])


def compare(pair, methods, iterations, mode, folder):
    name, source_file, target_file, voxel, no_zero_returns, rounds = pair
    source, target = (prepared(file, voxel, no_zero_returns, folder) for file in (source_file, target_file))
    files = folder / "source", folder / "target"
    source.tofile(files[0])
    target.tofile(files[1])
    runs, absent = {}, {}
    for _ in range(rounds):
        for method in methods:
            if method in absent:
                continue
            try:
                done = run(method, files, iterations, mode)
                runs.setdefault(method, []).append(done)
            except RuntimeError as error:
                absent[method] = str(error)
    tree = cKDTree(target)
    rows = {}
    for method, results in runs.items():
        transform = numpy.array(results[-1]["transform"], dtype=float)
        distances, _ = tree.query(source @ transform[:3, :3].T + transform[:3, 3])
        rows[method] = {
            "ms": statistics.median(result["ms"] for result in results),
            "rmse": float(numpy.sqrt(numpy.mean(distances**2))),
            "transform": transform.tolist(),
            "iterations": results[-1].get("iterations"),
            "searched": results[-1].get("searched"),
            "peak_mib": max(result["peak_mib"] for result in results),
            "runs_ms": [result["ms"] for result in results],
            "each_ms": results[-1].get("each_ms"),
        }
        print(f"  {method}: {rows[method]['ms']:.1f} ms", file=sys.stderr, flush=True)
    reference = numpy.loadtxt(SCANS / REFERENCES[source_file]).tolist() if source_file in REFERENCES else None
    return {"pair": name, "points": [len(source), len(target)], "rounds": rounds, "methods": rows, "absent": absent,
            "reference": reference}


def surface(n, seed):
    """n points of a hilly surface, 1000 to the square metre, so that the extent grows with n."""
    random = numpy.random.default_rng(seed)
    x, y = random.uniform(0, numpy.sqrt(n / 1000), (2, n))
    return numpy.stack([x, y, 0.4 * numpy.sin(1.7 * x) * numpy.cos(1.3 * y)], axis=1).astype("f4")


def grow(folder):
    rows = []
    files = folder / "source", folder / "target"
    moved = numpy.float32([0.02, -0.01, 0.015])
    for n in SIZES:
        (surface(n, 1) + moved).tofile(files[0])
        surface(n, 2).tofile(files[1])
        for method in ("ours, default", "ours, device", "small_gicp ICP"):
            try:
                result = run(method, files, GROWTH_ITERATIONS)
            except RuntimeError as error:
                print(f"  {method} is absent: {error}", file=sys.stderr)
                continue
            rows.append({"points": n, "method": method, **result})
            print(f"  {n} points, {method}: {result['ms']:.0f} ms", file=sys.stderr, flush=True)
    # One place, a million times: nothing in it may be quadratic.
    n = SIZES[-2]
    (surface(n, 1) + moved).tofile(files[0])
    numpy.full((n, 3), 1.5, "f4").tofile(files[1])
    rows.append({"points": n, "method": "ours, device, all target points in one place",
                 **run("ours, device", files, GROWTH_ITERATIONS)})
    return rows


def growth_table(rows):
    lines = ["| points onto as many | method | total | per point and iteration | tree | peak memory | on the device |",
             "|---|---|---|---|---|---|---|"]
    for row in rows:
        tree = f"{row['host_ms']['tree']:.0f} ms" if "host_ms" in row else ""
        held = f"{row['device_bytes'] / row['points']:.0f} bytes a point" if "device_bytes" in row else ""
        lines.append(
            f"| {row['points']} | {row['method']} | {row['ms']:.0f} ms | "
            f"{1e6 * row['ms'] / row['points'] / GROWTH_ITERATIONS:.0f} ns | {tree} | {row['peak_mib']:.0f} MiB | {held} |"
        )
    return "\n".join(lines)


def window_table(results):
    lines = ["| clouds | method | ten sources | ratio to stock | the first | the others, median |", "|---|---|---|---|---|---|"]
    for result in results:
        for method, row in result["methods"].items():
            first, *others = row["each_ms"]
            lines.append(
                f"| {result['pair']} | {method} | {row['ms']:.1f} ms | {result['methods']['stock PCL']['ms'] / row['ms']:.1f}x | "
                f"{first:.1f} ms | {statistics.median(others):.1f} ms |"
            )
    return "\n".join(lines)


def table(result, iterations):
    stock = next(iter(result["methods"].values()))
    distance = lambda row, other: 1e3 * numpy.linalg.norm(numpy.subtract(row["transform"], other)[:3, 3])
    lines = [
        f"**{result['pair']}**: {result['points'][0]} onto {result['points'][1]} points, {result['rounds']} runs",
        "",
        "| | total | ratio to stock | per iteration | RMSE | translation from stock's | from the reference | peak memory |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for method, row in result["methods"].items():
        done = row["iterations"] or iterations
        error = f"{distance(row, result['reference']):.1f} mm" if result["reference"] else ""
        each = f"{row['ms'] / done:.2f} ms ({done})" if done else ""
        lines.append(
            f"| {method} | {row['ms']:.1f} ms | {stock['ms'] / row['ms']:.1f}x | {each} | {row['rmse']:.5f} m | "
            f"{distance(row, stock['transform']):.2f} mm | {error} | {row['peak_mib']:.0f} MiB |"
        )
    lines += [f"\n{method} is absent: {why}" for method, why in result["absent"].items()]
    return "\n".join(lines)


def plot(results, converged, growth):
    figure, axes = plt.subplots(2, 2, figsize=(14, 9))
    axes = axes.ravel()
    for axis, group, title in (
        (axes[0], results, f"{ITERATIONS} point-to-point iterations"),
        (axes[1], converged, "to convergence"),
    ):
        methods = list(dict.fromkeys(method for result in group for method in result["methods"]))
        for i, method in enumerate(methods):
            heights = [result["methods"].get(method, {}).get("ms", numpy.nan) for result in group]
            positions = numpy.arange(len(group)) + (i - len(methods) / 2 + 0.5) * 0.8 / len(methods)
            axis.bar(positions, heights, 0.8 / len(methods), label=method)
        axis.set(yscale="log", ylabel="ms, trees included", title=title)
        axis.set_ylim(top=30 * axis.get_ylim()[1])  # room for the legend
        axis.set_xticks(range(len(group)), [result["pair"].replace(", ", "\n") for result in group])
        axis.legend(fontsize="small", ncol=2, loc="upper left")
    for result in results:
        row = result["methods"]["ours, device"]
        shares = [100 * count / result["points"][0] for count in row["searched"]]
        axes[2].plot(range(1, len(shares) + 1), shares, label=result["pair"])
    axes[2].set(xlabel="iteration", ylabel="% of the source points", title="points searched for (ours, device)")
    axes[2].legend(fontsize="small")
    for method in ("ours, default", "ours, device", "small_gicp ICP"):
        rows = [row for row in growth if row["method"] == method]
        axes[3].plot(
            [row["points"] for row in rows],
            [1e6 * row["ms"] / row["points"] / GROWTH_ITERATIONS for row in rows],
            "o-",
            label=method,
        )
    axes[3].set(xscale="log", yscale="log", xlabel="points onto as many", ylabel="ns per point and iteration",
                title=f"growth: {GROWTH_ITERATIONS} iterations, trees included")
    axes[3].legend(fontsize="small")
    figure.tight_layout()
    figure.savefig(OUTPUT / "compare.png", dpi=110)


def generalized(folder):
    methods = [*GENERALIZED, *PEERS_GENERALIZED]
    return ["### Generalized ICP, to convergence, covariances included\n"] + [
        table(compare(pair, methods, ITERATIONS_AT_MOST, "converge", folder), None) + "\n" for pair in PAIRS]


def main():
    OUTPUT.mkdir(parents=True, exist_ok=True)
    if sys.argv[4:] == ["generalized"]:
        with tempfile.TemporaryDirectory() as name:
            (OUTPUT / "generalized.md").write_text("\n".join(generalized(pathlib.Path(name))))
        return
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        results, converged, windows = [], [], []
        for pair in PAIRS:
            print(pair[0], file=sys.stderr, flush=True)
            results.append(compare(pair, [*OURS, *PEERS], ITERATIONS, None, folder))
            converged.append(
                compare(pair, [*OURS, *OTHER_PATHS, *PEERS_TO_CONVERGENCE], ITERATIONS_AT_MOST, "converge", folder))
            windows.append(compare(pair, [*OURS, PEERS[0]], ITERATIONS, "window", folder))
        print("growth", file=sys.stderr, flush=True)
        growth = grow(folder)
        of_generalized = generalized(folder)
    record = {
        "date": datetime.date.today().isoformat(),
        "machine": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "iterations": results,
        "convergence": converged,
        "window": windows,
        "growth": growth,
    }
    (OUTPUT / "compare.json").write_text(json.dumps(record, indent=1))
    text = [f"### {ITERATIONS} point-to-point iterations\n"] + [table(result, ITERATIONS) + "\n" for result in results]
    text += ["### To convergence\n"] + [table(result, None) + "\n" for result in converged]
    text += of_generalized
    text += ["### A moving window\n", window_table(windows), "\n### Growth\n", growth_table(growth)]
    (OUTPUT / "compare.md").write_text("\n".join(text))
    plot(results, converged, growth)


if __name__ == "__main__":
    main()
