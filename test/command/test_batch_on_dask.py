"""The sample that runs the shards of a manifest on a Dask cluster, one of whose two workers is killed half-way."""

import os
import pathlib
import signal
import subprocess
import sys
import time
import unittest

from batches import BatchTest, without_times
from command import COMMAND, NOT_CONVERGED, surface

SAMPLE = pathlib.Path(os.environ["PCL_GPU_ICP_SAMPLES"]) / "batch_on_dask.py"
SHARDS = 4
SLOW = surface(120, 100)


def python_with_dask():
    """Debian's package is for Debian's Python, which need not be the one that runs the tests."""
    for python in (sys.executable, "/usr/bin/python3"):
        try:
            if subprocess.run([python, "-c", "import distributed"], capture_output=True).returncode == 0:
                return python
        except FileNotFoundError:
            pass
    return None


PYTHON = python_with_dask()


def listening_addresses(pid):
    """Of a process's TCP sockets, in the hexadecimal of /proc."""
    inodes = set()
    for descriptor in pathlib.Path(f"/proc/{pid}/fd").iterdir():
        target = os.readlink(descriptor)
        if target.startswith("socket:["):
            inodes.add(target[len("socket:[") : -1])
    rows = [line.split() for table in ("tcp", "tcp6") for line in pathlib.Path(f"/proc/net/{table}").read_text().splitlines()[1:]]
    return {row[1].split(":")[0] for row in rows if row[3] == "0A" and row[9] in inodes}


def shard_at(worker):
    """The shard that a worker's command aligns, or None."""
    for children in pathlib.Path(f"/proc/{worker.pid}/task").glob("*/children"):
        for child in children.read_text().split():
            try:
                words = pathlib.Path(f"/proc/{child}/cmdline").read_bytes().decode().split("\0")
            except FileNotFoundError:
                continue
            if "--shard" in words and words[0] == COMMAND:
                return words[words.index("--shard") + 1].split("/")[0]
    return None


@unittest.skipUnless(PYTHON, "python3-distributed is not installed")
class Dask(BatchTest):
    def start(self, *arguments):
        log = open(self.path(f"{arguments[0]}.log"), "a")
        self.addCleanup(log.close)
        process = subprocess.Popen(
            [PYTHON, "-m", f"distributed.cli.{arguments[0]}", *arguments[1:], "--host", "127.0.0.1",
             "--dashboard-address", "127.0.0.1:0", "--no-dashboard"],
            cwd=self.directory, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        self.addCleanup(self.end, process)
        return process

    def end(self, process):
        process.kill()
        process.wait(timeout=60)

    def wait_for(self, condition, what):
        deadline = time.monotonic() + 120
        while not (result := condition()):
            self.assertLess(time.monotonic(), deadline, what)
            time.sleep(0.002)
        return result

    def test_a_worker_is_killed_half_way(self):
        source, target = self.pairs(1, SLOW)[0]
        rows = [(source, target, str(5 + i)) for i in range(15 * SHARDS)] + [("none.pcd", target, "")]
        manifest = self.manifest(rows, ("source", "target", "iterations"))
        options = ["--reciprocal", "--fitness-epsilon", "1e-300"]
        single, _ = self.batch(manifest, *options, output="single", code=NOT_CONVERGED)

        file = self.path("scheduler.json")
        scheduler = self.start("dask_scheduler", "--port", "0", "--scheduler-file", file)
        self.wait_for(lambda: os.path.exists(file), "the scheduler starts")
        workers = [
            self.start("dask_worker", "--scheduler-file", file, "--nthreads", "1", "--no-nanny", "--name", name,
                       "--local-directory", self.path(name))
            for name in ("one", "two")]
        sample = subprocess.Popen(
            [PYTHON, SAMPLE, "--shards", str(SHARDS), "--command", COMMAND, file, manifest, self.path("out"), *options],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.end, sample)

        shard = self.wait_for(lambda: shard_at(workers[0]), "a worker gets a shard")
        self.wait_for(lambda: shard_at(workers[1]), "the other one, too")
        results = pathlib.Path(self.path(f"out/results-{shard}-of-{SHARDS}.jsonl"))
        self.wait_for(lambda: results.exists() and results.read_bytes().count(b"\n") >= 3, "there are results")
        for process in (scheduler, *workers):
            self.assertEqual(listening_addresses(process.pid), {"0100007F"}, "only 127.0.0.1 is listened at")
        self.assertEqual(shard_at(workers[0]), shard, "the worker is killed in the middle of it")
        workers[0].send_signal(signal.SIGKILL)

        stdout, stderr = sample.communicate(timeout=300)
        self.assertEqual(sample.returncode, NOT_CONVERGED, stderr)
        converged = sum(result["status"] == "converged" for result in single.values())
        self.assertEqual(stdout, f"{len(rows)} pairs, {converged} converged, {len(rows) - 1 - converged} at the limit, "
                                 "0 not converged, 1 failed\n")
        self.assertEqual(workers[0].wait(timeout=60), -signal.SIGKILL)
        self.assertIsNone(workers[1].poll())
        self.assertEqual(without_times(self.results()), without_times(single))
        self.assertEqual(set(self.results()), set(range(len(rows))))
        self.assertGreaterEqual(self.summary("out", f"summary-{shard}-of-{SHARDS}.json")["kept"], 3,
                                "the other worker went on where the killed one was")
