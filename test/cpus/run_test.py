#!/usr/bin/env python3
"""run_test.py COMMAND KERNELS: runs the command as on CPUs with narrower vectors than this one may have, and compares with
what it says on this one. qemu executes no AVX-512. The folder KERNELS keeps what was compiled, so only the first run, and
the first after a kernel changes, is as slow as qemu compiles."""

import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

COMMAND, KERNELS = sys.argv[1:3]
# As qemu names them: one with SSE4, and one with all that qemu has, which includes AVX2.
CPUS = ("Nehalem", "max")


def surface(turn=0.0, shift=0.0):
    """Hills with no symmetry, turned about z."""
    c, s = math.cos(turn), math.sin(turn)
    points = ((0.25 * i, 0.25 * j, 0.4 * math.sin(0.225 * i) * math.cos(0.325 * j) + 0.00125 * i * j * j)
              for j in range(20) for i in range(24))
    return [(c * x - s * y + shift, s * x + c * y, z - shift) for x, y, z in points]


def pcd(points):
    header = (f"VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {len(points)}\nHEIGHT 1\n"
              f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\nDATA ascii\n")
    return header + "".join("%.9g %.9g %.9g\n" % point for point in points)


class OtherCpus(unittest.TestCase):
    def align(self, *runner, kernels):
        with tempfile.TemporaryDirectory() as folder:
            source, target, matrix = (os.path.join(folder, name) for name in ("source.pcd", "target.pcd", "matrix.txt"))
            pathlib.Path(source).write_text(pcd(surface()))
            pathlib.Path(target).write_text(pcd(surface(0.05, 0.08)))
            done = subprocess.run(
                [*runner, COMMAND, "align", "--search", "device", source, target, "--matrix", matrix],
                env={**os.environ, "POCL_CACHE_DIR": kernels, "OCL_ICD_VENDORS": "/etc/OpenCL/vendors/pocl.icd"},
                stdin=subprocess.DEVNULL, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done)
            self.assertRegex(done.stderr, r"\A(pcl_gpu_icp: compiling kernels for this device, once: [^\n]+\n)?\Z")
            device = next(line for line in done.stdout.splitlines() if line.startswith("device "))
            return device, [float(word) for word in pathlib.Path(matrix).read_text().split()]

    def test_agree_with_this_one(self):
        _, here = self.align(kernels=os.path.join(KERNELS, "here"))
        devices = set()
        self.assertAlmostEqual(math.atan2(here[4], here[0]), 0.05, delta=1e-3)
        for cpu in CPUS:
            with self.subTest(cpu):
                device, there = self.align("qemu-x86_64", "-cpu", cpu, kernels=os.path.join(KERNELS, cpu))
                devices.add(device)
                for a, b in zip(here, there):
                    self.assertAlmostEqual(a, b, delta=1e-5)
        self.assertEqual(len(devices), len(CPUS), "PoCL compiles for each of them")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
