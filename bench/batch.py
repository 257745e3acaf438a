"""Many cloud pairs: one after another, in batches by every policy, and stock PCL in a process per core, interleaved.

batch.py BINARIES SCANS OUTPUT writes OUTPUT/batch.json with every run, OUTPUT/batch.md with the tables of BENCHMARK.md, and
OUTPUT/batch.png."""

import concurrent.futures
import datetime
import json
import os
import pathlib
import statistics
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

BINARIES, SCANS, OUTPUT = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
CORES = os.cpu_count()

# Workload, what it is, pairs, runs.
WORKLOADS = [("small", "7k points", 64, 7), ("large", "60k points", 64, 5), ("mix", "2k to 270k points", 64, 5)]
METHODS = {
    "one after another": ["sequence"],
    "batch": ["batch"],
    "batch, first come first served": ["batch", "--policy", "fifo"],
    "batch, largest first": ["batch", "--policy", "largest"],
    "batch, one lane": ["batch", "--lanes", "1"],
    "batch, 64 work-items": ["batch", "--capacity", "64"],
    "batch, 64 work-items, first come first served": ["batch", "--capacity", "64", "--policy", "fifo"],
    "batch, 64 work-items, largest first": ["batch", "--capacity", "64", "--policy", "largest"],
}
STOCK_PAIRS, STOCK_RUNS = 32, 3
TINY_PAIRS = 10_000


def run(*arguments):
    command = [BINARIES / "bench/batch_benchmark", SCANS, *map(str, arguments)]
    # Threads stay on cores of their own: some kernels wake them all on one.
    done = subprocess.run(command, capture_output=True, text=True, env={"POCL_AFFINITY": "1", **os.environ})
    if done.returncode != 0:
        raise RuntimeError(done.stderr.strip().splitlines()[-1])
    return json.loads(done.stdout)


def measure(workload, pairs, rounds):
    runs = {method: [] for method in METHODS}
    for _ in range(rounds):
        for method, arguments in METHODS.items():
            runs[method].append(run(workload, *arguments, "--pairs", pairs))
    return runs


def median(runs, value):
    return statistics.median(map(value, runs))


def table(what, pairs, runs):
    lines = [
        f"**{pairs} pairs of {what}**, {len(runs['batch'])} runs",
        "",
        "| | all pairs | ratio | the median pair finishes | ratio | cores busy | device busy |",
        "|---|---|---|---|---|---|---|",
    ]
    total = {method: median(of, lambda r: r["ms"]) for method, of in runs.items()}
    middle = {method: median(of, lambda r: statistics.median(r["finished_ms"])) for method, of in runs.items()}
    for method, of in runs.items():
        busy = f"{100 * median(of, lambda r: r['utilisation']['busy']):.0f} %" if "utilisation" in of[0] else ""
        lines.append(
            f"| {method} | {total[method]:.0f} ms | {total['one after another'] / total[method]:.2f}x | "
            f"{middle[method]:.0f} ms | {middle['one after another'] / middle[method]:.2f}x | "
            f"{median(of, lambda r: r['cpu_ms'] / r['ms']):.2f} | {busy} |")
    return "\n".join(lines)


def against_stock():
    """Pairs of 7k points per second: stock PCL in a process per core, and batches."""
    rates = {"stock PCL, a process per core": [], "batch, PCL's tree": [], "batch, device": []}
    for _ in range(STOCK_RUNS):
        with concurrent.futures.ThreadPoolExecutor(CORES) as pool:
            parts = [
                pool.submit(run, "small", "stock", "--pairs", STOCK_PAIRS, "--first", core, "--step", CORES)
                for core in range(CORES)
            ]
            slowest = max(part.result()["ms"] for part in parts)
        rates["stock PCL, a process per core"].append(1e3 * STOCK_PAIRS / slowest)
        for method, search in ("batch, PCL's tree", "pcl"), ("batch, device", "device"):
            done = run("small", "batch", "--pairs", STOCK_PAIRS, "--search", search)
            rates[method].append(1e3 * STOCK_PAIRS / done["ms"])
    return rates


def stock_table(rates):
    stock = statistics.median(rates["stock PCL, a process per core"])
    lines = ["| | pairs per second | ratio |", "|---|---|---|"]
    for method, of in rates.items():
        lines.append(f"| {method} | {statistics.median(of):.1f} | {statistics.median(of) / stock:.1f}x |")
    return "\n".join(lines)


def plot(workloads, tiny):
    figure, (left, right) = plt.subplots(1, 2, figsize=(14, 5))
    for method in ("one after another", "batch", "batch, first come first served", "batch, largest first"):
        finished = sorted(workloads["mix"][method][0]["finished_ms"])
        left.plot(finished, range(1, len(finished) + 1), label=method)
    left.set(xlabel="ms", ylabel="pairs finished", title="64 pairs of 2k to 270k points")
    left.legend()
    finished = range(100, 100 * len(tiny["resident_kb"]) + 1, 100)
    right.plot(finished, [kb / 1024 for kb in tiny["resident_kb"]], label="resident memory")
    right.set(xlabel="pairs finished", ylabel="MiB", title=f"{TINY_PAIRS} pairs of 64 points")
    right.set_ylim(bottom=0)
    files = right.twinx()
    files.plot(finished, tiny["open_files"], "C1", label="open files")
    files.set_ylim(bottom=0, top=2 * max(tiny["open_files"]))
    files.set_ylabel("open files")
    right.legend(loc="lower left")
    files.legend(loc="lower right")
    figure.tight_layout()
    figure.savefig(OUTPUT / "batch.png", dpi=110)


def tiny_text(tiny):
    memory, files = tiny["resident_kb"], tiny["open_files"]
    return (f"{TINY_PAIRS} pairs of 64 points: {memory[0] / 1024:.0f} MiB resident after the first hundred, "
            f"{memory[-1] / 1024:.0f} MiB in the end; {files[0]} files open after the first hundred, {files[-1]} in the end; "
            f"{1e3 * TINY_PAIRS / tiny['ms']:.0f} pairs per second.")


def main():
    OUTPUT.mkdir(parents=True, exist_ok=True)
    workloads = {}
    text = []
    for name, what, pairs, rounds in WORKLOADS:
        print(name, file=sys.stderr, flush=True)
        workloads[name] = measure(name, pairs, rounds)
        text.append(table(what, pairs, workloads[name]) + "\n")
    print("stock", file=sys.stderr, flush=True)
    rates = against_stock()
    text.append(f"**{STOCK_PAIRS} pairs of 7k points**, {STOCK_RUNS} runs\n\n" + stock_table(rates) + "\n")
    print("tiny", file=sys.stderr, flush=True)
    tiny = run("tiny", "batch", "--pairs", TINY_PAIRS, "--iterations", 10)
    text.append(tiny_text(tiny) + "\n")
    record = {"date": datetime.date.today().isoformat(), "cores": CORES, "workloads": workloads, "stock": rates, "tiny": tiny}
    (OUTPUT / "batch.json").write_text(json.dumps(record))
    (OUTPUT / "batch.md").write_text("\n".join(text))
    plot(workloads, tiny)


if __name__ == "__main__":
    main()
