#!/usr/bin/env python3
"""scripts/gpu-audit tells of every kernel what GPUs' compilers make of it, that the hot ones do with registers, and
which do not."""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# What the array holds is known only when the kernel runs: no compiler keeps it in registers.
INDEXED_ARRAY = """
kernel void nearest(global const int* indices, global float* values)
{
  float held[64];
  for (int i = 0; i < 64; ++i)
    held[indices[i] & 63] = values[i];
  for (int i = 0; i < 64; ++i)
    values[i] = held[indices[64 + i] & 63];
}
"""


def audit(*arguments):
    with tempfile.TemporaryDirectory() as place:
        output = pathlib.Path(place) / "audit.md"
        done = subprocess.run([ROOT / "scripts" / "gpu-audit", "--output", output, *arguments], text=True,
                              capture_output=True)
        return done, output.read_text() if output.exists() else ""


def source_of(file):
    """A program's source as the runtime puts it together: with every file that it includes."""
    text = (ROOT / "kernels" / file).read_text()
    return re.sub(r'^#include "(.*)"', lambda include: source_of(include.group(1)), text, flags=re.M)


def kernels():
    return {f"{path.name}: {name}" for path in (ROOT / "kernels").glob("*.cl")
            for name in re.findall(r"^kernel void (\w+)\(", source_of(path.name), flags=re.M)}


def told_of(text):
    return set(re.findall(r"^\| (\w+\.cl: \w+) \|", text, flags=re.M))


class GpuAudit(unittest.TestCase):
    maxDiff = None

    def test_every_kernel_is_told_of_and_the_hot_ones_need_registers_only(self):
        done, text = audit()
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(done.stdout, text)
        self.assertEqual(told_of(text), kernels())
        for architecture in ("gfx900", "gfx1030", "gfx1100", "SPIR-V"):
            for kernel in kernels():
                for precision in ("float", "double"):
                    self.assertIn(f"| {kernel} | {precision} | {architecture} |", text)
        self.assertRegex(text, r"\| match\.cl: match \| double \| (sm_80|PTX) \|")

    def test_the_document_is_about_the_kernels_that_are_there(self):
        self.assertEqual(told_of((ROOT / "docs" / "gpu_audit.md").read_text()), kernels())

    def test_a_hot_kernel_that_needs_more_is_an_error(self):
        with tempfile.TemporaryDirectory() as place:
            (pathlib.Path(place) / "nearest.cl").write_text(INDEXED_ARRAY)
            done, text = audit("--kernels", place)
            self.assertEqual(done.returncode, 1, done.stderr)
            for architecture in ("gfx900", "SPIR-V"):
                self.assertRegex(done.stderr, rf"nearest.cl: nearest in double on {architecture}: stack \S+ ?[1-9]*")
            self.assertRegex(text, r"\| nearest.cl: nearest \| float \| gfx900 \| \d+ \| \*\*2[56]\d\*\* \|")

            # A kernel of that name elsewhere is not a hot one.
            (pathlib.Path(place) / "nearest.cl").rename(pathlib.Path(place) / "seldom.cl")
            done, text = audit("--kernels", place)
            self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_a_kernel_that_does_not_compile_is_an_error(self):
        with tempfile.TemporaryDirectory() as place:
            (pathlib.Path(place) / "nearest.cl").write_text("kernel void nearest(global float* values) { values = 1; }")
            done, _ = audit("--kernels", place)
            self.assertEqual(done.returncode, 2)
            self.assertIn("nearest.cl:1:", done.stderr)
            done, _ = audit("--kernels", f"{place}/none")
            self.assertEqual(done.returncode, 2)
            self.assertIn(f"no kernels in {place}/none", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
