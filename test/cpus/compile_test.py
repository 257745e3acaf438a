#!/usr/bin/env python3
"""Compiles every kernel in both shapes and precisions, as OpenCL implementations that are based on clang do, for CPUs
with vectors of every width: no warning anywhere."""

import concurrent.futures
import itertools
import os
import pathlib
import subprocess
import sys

KERNELS = pathlib.Path(__file__).resolve().parents[2] / "kernels"
CPUS = {
    "SSE4": ["--target=x86_64-linux-gnu", "-march=nehalem"],
    "AVX": ["--target=x86_64-linux-gnu", "-march=sandybridge"],
    "AVX2": ["--target=x86_64-linux-gnu", "-march=haswell"],
    "AVX-512": ["--target=x86_64-linux-gnu", "-march=skylake-avx512"],
    "NEON": ["--target=aarch64-linux-gnu"],
}
SHAPES = (["-DCHUNKED"], ["-DWORK_GROUP_SIZE=128"])
PRECISIONS = ([], ["-DREAL_IS_DOUBLE", "-Dcl_khr_fp64"])
# What OpenCL implementations set by themselves.
OPENCL = ["-x", "cl", "-cl-std=CL1.2", "-D__OPENCL_VERSION__=120", "-Xclang", "-finclude-default-header",
          "-Xclang", "-cl-ext=+cl_khr_fp64", "-Wall", "-Werror", "-S", "-emit-llvm", "-o", os.devnull]


def errors(kernel, cpu, shape, precision):
    options = [*CPUS[cpu], *shape, *precision]
    done = subprocess.run(["clang", *OPENCL, *options, "-"], input=kernel.read_bytes(), cwd=KERNELS, capture_output=True)
    said = (done.stdout + done.stderr).decode()
    return f"{kernel.name} for {cpu}, {' '.join(shape + precision)}:\n{said}" if said or done.returncode else ""


def main():
    kernels = sorted(KERNELS.glob("*.cl"))
    everything = list(itertools.product(kernels, CPUS, SHAPES, PRECISIONS))
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        failed = [said for said in pool.map(lambda one: errors(*one), everything) if said]
    print("\n".join(failed[:20]))
    print(f"{len(everything)} compiled, {len(failed)} not without a word")
    return 1 if failed or not everything else 0


if __name__ == "__main__":
    sys.exit(main())
