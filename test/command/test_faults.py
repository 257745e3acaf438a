"""Calls of OpenCL and of the system that fail: the command says which, ends with its code, and leaves nothing half done.

test/rooms/faults_test.cpp has more of OpenCL's; these are of whole processes. PCL_GPU_ICP_EVERY_FAULT=1 fails each of the
first hundred calls of each function.
"""

import concurrent.futures
import errno
import os
import pathlib
import re
import shutil
import tempfile
import unittest

from batches import BatchTest
from command import DEVICE, INTERNAL, NOT_CONVERGED, OUTPUT, SANITIZED, SUCCESS, motion, moved, pcd, surface

EVERY = os.environ.get("PCL_GPU_ICP_EVERY_FAULT") == "1"
POINTS = surface()
TARGET = [moved(motion(3, (0.05, -0.08, 0.04)), point) for point in POINTS]
OUT_OF_RESOURCES, OUT_OF_RESOURCES_NAME = -5, "CL_OUT_OF_RESOURCES"
WRITES_HALF = -1


@unittest.skipIf(SANITIZED, "a sanitizer has to be in front of all other libraries")
class Faults(BatchTest):
    def setUp(self):
        super().setUp()
        self.source = self.write("source.pcd", pcd(POINTS, "binary"))
        self.target = self.write("target.pcd", pcd(TARGET, "binary"))

    def run_with(self, arguments, fault=None, existing=()):
        """Runs a command in a folder of its own, which stands for OUT in its arguments. Returns what came of it, the
        counts of calls and of what was left, and the files that are there."""
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.directory))
        report = pathlib.Path(tempfile.mkdtemp(dir=self.directory)) / "report"
        for name in existing:
            (folder / name).write_text("precious")
        environment = {
            "LD_PRELOAD": os.environ["PCL_GPU_ICP_FAULTS"], "PCL_GPU_ICP_FAULT_REPORT": str(report),
            "PCL_GPU_ICP_DEVICE": "cpu"}
        if fault:
            environment["PCL_GPU_ICP_FAULT"] = ":".join(map(str, fault))
        done = self.run_command(
            *[str(argument).replace("OUT", str(folder)) for argument in arguments], environment=environment)
        counts = {"calls": {}, "left": {}}
        if report.exists():
            for line in report.read_text().splitlines():
                kind, name, count = line.split()
                counts[kind][name] = int(count)
        files = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
        shutil.rmtree(folder)
        return done, counts, files

    def chosen(self, count):
        return range(1, min(count, 100) + 1) if EVERY else [count]

    def each(self, arguments, faults, check, **settings):
        """Runs them all, two at a time, and checks each: no end is one of a crash."""
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            runs = pool.map(lambda fault: (fault, self.run_with(arguments, fault, **settings)), faults)
            for fault, (done, counts, files) in runs:
                with self.subTest(arguments=arguments, fault=fault):
                    self.assertGreaterEqual(done.returncode, 0, done)
                    self.assertFalse([name for name in files if ".pcl_gpu_icp." in name], "no temporary file is left")
                    check(fault, done, counts, files)

    def opencl_faults(self, calls):
        self.assertGreater(calls["clGetDeviceInfo"], 0)
        return [(function, call, OUT_OF_RESOURCES)
                for function, count in calls.items() if re.match("cl[A-Z]", function)
                for call in self.chosen(count)]

    def assert_names_the_call(self, text, function):
        self.assertIn("clRetain..." if function.startswith("clRetain") else function + " failed", text)
        self.assertIn(OUT_OF_RESOURCES_NAME, text)

    def assert_nothing_left(self, function, counts):
        if not function.startswith("clRelease"):
            self.assertEqual([counts["left"].get(kind, 0) for kind in ("buffer", "queue", "kernel", "event")], [0] * 4)

    def test_opencl_of_align(self):
        for options in ([[]] if EVERY else []) + [["--search", "device", "--metric", "plane"]]:
            arguments = ["align", self.source, self.target, "-o", "OUT/out.pcd", "--matrix", "OUT/m.txt", "--quiet",
                         *options]
            done, counts, whole = self.run_with(arguments)
            self.assertEqual((done.returncode, done.stderr, set(whole)), (SUCCESS, "", {"out.pcd", "m.txt"}))
            self.assert_nothing_left("", counts)

            def check(fault, done, counts, files):
                function = fault[0]
                self.assert_nothing_left(function, counts)
                if done.returncode == SUCCESS: # what only ends something has no say in the answer
                    self.assertRegex(function, r"clRelease|clFinish|clEnqueueUnmapMemObject")
                    self.assertEqual((done.stderr, files), ("", whole))
                    return
                self.assertEqual(done.returncode, DEVICE, done)
                self.assertRegex(done.stderr, r"\Apcl_gpu_icp: [^\n]+\n\Z")
                self.assert_names_the_call(done.stderr, function)
                self.assertEqual(files, {})

            self.each(arguments, self.opencl_faults(counts["calls"]), check)

    def test_opencl_of_devices_and_compare(self):
        for arguments in (["devices"], ["compare", self.source, self.target, "--metric", "plane", "--quiet"]):
            _, counts, _ = self.run_with(arguments)

            def check(fault, done, counts, files):
                if done.returncode != SUCCESS:
                    self.assertEqual(done.returncode, DEVICE, done)
                    self.assert_names_the_call(done.stderr, fault[0])
                else:
                    self.assertRegex(fault[0], r"clRelease|clFinish|clEnqueueUnmapMemObject")

            faults = self.opencl_faults(counts["calls"])
            self.each(arguments, faults if EVERY else faults[::4], check)

    def test_opencl_of_a_batch(self):
        """A failure is its pair's: the others get what they get without it."""
        rows = self.pairs(4)
        manifest = self.manifest([(self.path(source), self.path(target)) for source, target in rows])
        arguments = ["batch", manifest, "-o", "OUT", "--pairs-in-flight", "2", "--search", "device", "--quiet"]
        done, counts, files = self.run_with(arguments)
        self.assertEqual(done.returncode, SUCCESS, done)
        transforms = {pair: result["transform"] for pair, result in self.of(files).items()}

        def check(fault, done, counts, files):
            function = fault[0]
            self.assert_nothing_left(function, counts)
            if done.returncode == DEVICE: # before anything ran
                self.assert_names_the_call(done.stderr, function)
                return
            results = self.of(files)
            failed = [result for result in results.values() if result["status"] == "failed"]
            self.assertEqual(len(results), len(rows))
            self.assertEqual(done.returncode, NOT_CONVERGED if failed else SUCCESS, done)
            if not failed:
                self.assertRegex(function, r"clRelease|clFinish|clEnqueueUnmapMemObject")
            for result in failed:
                self.assertEqual(result["error"]["kind"], "device")
                self.assert_names_the_call(result["error"]["message"], function)
            self.assertLessEqual(len(failed), 1)
            for pair, result in results.items():
                self.assertEqual(result.get("transform", transforms[pair]), transforms[pair])

        faults = self.opencl_faults(counts["calls"])
        self.each(arguments, faults if EVERY else faults[::2], check)

    def of(self, files):
        lines = files["results.jsonl"].decode().splitlines()
        results = [self.checked(line, pathlib.Path(os.environ["PCL_GPU_ICP_SCHEMA"]).with_name("batch.schema.json"))
                   for line in lines]
        return {result["pair"]: result for result in results}

    def test_memory(self):
        for options in ([], ["--search", "device", "--metric", "plane"]):
            arguments = ["align", self.source, self.target, "-o", "OUT/out.pcd", "--matrix", "OUT/m.txt", *options]
            _, counts, _ = self.run_with(arguments)
            count = counts["calls"]["allocate"]

            def check(fault, done, counts, files):
                self.assertEqual((done.returncode, done.stderr), (INTERNAL, "pcl_gpu_icp: out of memory\n"))
                self.assertEqual(files, {})

            calls = range(1, count + 1) if EVERY else range(1, count + 1, 12)
            self.each(arguments, [("allocate", call, errno.ENOMEM) for call in calls], check)

    def test_memory_of_a_batch(self):
        rows = self.pairs(2)
        manifest = self.manifest([(self.path(source), self.path(target)) for source, target in rows])
        arguments = ["batch", manifest, "-o", "OUT", "--quiet"]
        _, counts, _ = self.run_with(arguments)
        count = counts["calls"]["allocate"]

        def check(fault, done, counts, files):
            self.assertIn(done.returncode, (NOT_CONVERGED, INTERNAL), done)
            if done.returncode == INTERNAL:
                self.assertEqual(done.stderr, "pcl_gpu_icp: out of memory\n")
                return
            failed = [result for result in self.of(files).values() if result["status"] == "failed"]
            self.assertEqual([result["error"] for result in failed], [{"kind": "internal", "message": "out of memory"}])

        calls = range(1, count + 1) if EVERY else range(1, count + 1, 25)
        self.each(arguments, [("allocate", call, errno.ENOMEM) for call in calls], check)

    def file_faults(self, calls):
        """Of what writes: reading has an exit code of its own."""
        self.assertGreater(calls["write"], 0)
        codes = {
            "write": (errno.ENOSPC, errno.EIO, errno.EINTR, WRITES_HALF), "fsync": (errno.EIO, errno.ENOSPC, errno.EINTR),
            "close": (errno.EIO, errno.EINTR), "mkstemp": (errno.EACCES, errno.ENOSPC), "fchmod": (errno.EPERM,),
            "rename": (errno.EACCES, errno.EIO), "renameat2": (errno.EACCES, errno.ENOSPC)}
        return [(function, call, code) for function, of in codes.items()
                for call in range(1, calls.get(function, 0) + 1) for code in (of if EVERY else (of[0], of[-1]))]

    def test_files_of_align(self):
        names = ["out.pcd", "both.ply", "m.txt", "j.json"]
        for existing in ([[]] if EVERY else []) + [names]:
            arguments = ["align", self.source, self.target, "-o", "OUT/out.pcd", "--both", "OUT/both.ply", "--matrix",
                         "OUT/m.txt", "--json", "OUT/j.json", "--quiet", *(["--force"] if existing else [])]
            done, counts, whole = self.run_with(arguments, existing=existing)
            self.assertEqual(set(whole), set(names))
            self.assertEqual(counts["calls"]["write"], 4)
            reads = counts["calls"]["close"] - 4

            def check(fault, done, counts, files):
                function, call, code = fault
                passes = code in (errno.EINTR, WRITES_HALF) or function == "close" and call <= reads
                if passes:
                    self.assertEqual((done.returncode, done.stderr), (SUCCESS, ""), done)
                    self.assertEqual({name: files[name] for name in names[:3]}, {name: whole[name] for name in names[:3]})
                    return
                self.assertEqual(done.returncode, OUTPUT, done)
                self.assertRegex(done.stderr, r"\Apcl_gpu_icp: [^\n]+\n\Z")
                which = call - 1 - (reads if function == "close" else 0)
                self.assertIn(names[which] + ": " + os.strerror(code), done.stderr)
                self.assertEqual(files, {name: b"precious" for name in existing})

            self.each(arguments, self.file_faults(counts["calls"]), check, existing=existing)

    def test_files_of_a_batch(self):
        rows = self.pairs(2)
        manifest = self.manifest([(self.path(source), self.path(target)) for source, target in rows])
        arguments = ["batch", manifest, "-o", "OUT", "--pairs-in-flight", "1", "--quiet"]
        _, counts, whole = self.run_with(arguments)
        self.assertEqual(set(whole), {"results.jsonl", "summary.json"})

        def check(fault, done, counts, files):
            function, call, code = fault
            self.assertIn(done.returncode, (SUCCESS, OUTPUT), done)
            text = files.get("results.jsonl", b"").decode()
            self.assertTrue(text == "" or text.endswith("\n"), "whole lines only")
            if done.returncode == SUCCESS:
                self.assertTrue(code in (errno.EINTR, WRITES_HALF) or function == "close", fault)
                self.assertEqual(set(files), set(whole))
                return
            self.assertRegex(done.stderr, r"\Apcl_gpu_icp: [^\n]+\n\Z")
            self.assertIn(os.strerror(code), done.stderr)
            self.assertNotIn("summary.json", files)

        more = [(function, 1, errno.EIO) for function in ("ftruncate", "flock", "mkdir") if function in counts["calls"]]
        self.each(arguments, self.file_faults(counts["calls"]) + more, check)
