#!/usr/bin/env python3
"""Aligns the pairs of a manifest on the workers of a Dask cluster and puts their results together.

    batch_on_dask.py [--shards N] [--command PCL_GPU_ICP] SCHEDULER MANIFEST DIR [OPTION OF BATCH ...]

SCHEDULER is its address, e.g. tcp://127.0.0.1:8786, or the file that dask-scheduler --scheduler-file wrote. Every worker
aligns one shard of the manifest after another; the manifest, the scans and DIR are on a file system that all of them
have. A shard whose worker dies goes on at another one, from where it was. DIR/results.jsonl has all the results in the
end, as of one run of pcl_gpu_icp batch on one machine.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys

from distributed import Client

ALL_CONVERGED, SOME_DID_NOT = 0, 1


def run_shard(command, manifest, directory, shard, shards, options):
    """Runs on a worker. What cannot be helped there is an error, so that Dask tries again."""
    name = f"{shard}/{shards}"
    # The command ends with its worker: two may not write the same file.
    ends_with_us = ["setpriv", "--pdeathsig", "KILL"]
    done = subprocess.run(
        [*ends_with_us, command, "batch", manifest, "-o", directory, "--shard", name, "--resume", "--quiet", *options],
        stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode not in (ALL_CONVERGED, SOME_DID_NOT):
        raise RuntimeError(f"shard {name}: exit {done.returncode}: {done.stderr.strip()}")
    return done.returncode


def merge(directory, shards):
    """Concatenates the results of the shards into a file that appears whole."""
    merged = directory / "results.jsonl.part"
    with open(merged, "wb") as file:
        for shard in range(1, shards + 1):
            file.write((directory / f"results-{shard}-of-{shards}.jsonl").read_bytes())
    os.replace(merged, directory / "results.jsonl")


def main():
    parser = argparse.ArgumentParser(description="Aligns the pairs of a manifest on the workers of a Dask cluster.")
    parser.add_argument("--shards", type=int, help="parts of the manifest (default: four for each worker)")
    parser.add_argument("--command", default="pcl_gpu_icp", help="as the workers find it")
    parser.add_argument("scheduler")
    parser.add_argument("manifest", type=pathlib.Path)
    parser.add_argument("directory", type=pathlib.Path)
    parser.add_argument("options", nargs=argparse.REMAINDER, help="of pcl_gpu_icp batch, for every shard")
    arguments = parser.parse_args()
    directory = arguments.directory.resolve()
    directory.mkdir(exist_ok=True)

    is_file = os.path.exists(arguments.scheduler)
    with Client(scheduler_file=arguments.scheduler) if is_file else Client(arguments.scheduler) as client:
        shards = arguments.shards or 4 * max(1, len(client.scheduler_info()["workers"]))
        tasks = [
            client.submit(run_shard, arguments.command, str(arguments.manifest.resolve()), str(directory), shard, shards,
                          arguments.options, pure=False, retries=3)
            for shard in range(1, shards + 1)]
        codes = client.gather(tasks)

    merge(directory, shards)
    summaries = [json.loads((directory / f"summary-{i}-of-{shards}.json").read_text()) for i in range(1, shards + 1)]
    counted = ("pairs", "converged", "at_the_limit", "not_converged", "failed")
    total = {key: sum(summary[key] for summary in summaries) for key in counted}
    print(", ".join(f"{value} {key.replace('_', ' ')}" for key, value in total.items()))
    return max(codes)


if __name__ == "__main__":
    sys.exit(main())
