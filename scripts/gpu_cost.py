"""What an iteration must at least move and compute on a GPU, and the time that takes at the rates that the GPU's makers
publish: a prediction that no GPU here has been asked about."""

import typing


class Gpu(typing.NamedTuple):
    name: str
    memory: float  # GB/s
    float_rate: float  # Gflop/s, a fused multiply-add being two
    double_rate: typing.Optional[float]  # None: it has no double, and sums are in float


# NVIDIA's data sheets and CUDA's table of arithmetic throughput, Intel's ARK, Arm's GPU data sheet with the clock and
# memory of Samsung's Exynos 2100.
GPUS = (
    Gpu("H100 SXM", 3350, 66_900, 33_500),
    Gpu("RTX 4060", 272, 15_110, 15_110 / 64),
    Gpu("Jetson AGX Orin", 204.8, 5_325, 5_325 / 64),
    Gpu("Arc A770", 560, 17_200, None),
    Gpu("Mali-G78 MP14", 51.2, 14 * 64 * 0.854, None),
)
LAUNCH = 5  # us; what drivers usually take for a launch, and as much for a wait of the host
POINTS = (271_000, 1_000_000)


class Work(typing.NamedTuple):
    """Of a kernel, for each source point; see kernels/layout.h for what is read and written."""

    kernel: str
    moved: float  # bytes that come from or go to memory when caches hold what is read twice
    float_operations: float
    sum_operations: float  # in the precision of the sums, conversions to it among them


# Operations are counted by hand, a square root or division as ten. A reduction adds half a value per point and sum.
MOVE = 18  # R p + t
DISTANCE = 8
# Per query, as measured on lidar_street (docs/decisions/0005): nodes and leaves visited, of sixteen boxes and points.
NODES, LEAVES = 3.8, 2.2
BOX, POINT = 21, DISTANCE + 30  # a point is also put into its place among four
SEARCH = 16 * (NODES * BOX + LEAVES * POINT)

POINT_SUMS = 7 + 6 + 9 * 2 + 1 + 16 / 2
PLANE_SUMS = 9 + 6 + 9 + 9 + 1 + 6 + 21 * 2 + 6 * 2 + 1 + 32 / 2
GENERALIZED_SUMS = 19 + 6 + 45 + 36 + 18 + 15 + 6 + 15 + 5 + 3 + 27 + 24 + 9 + 6 + 12 + 3 + 1 + 32 / 2

POSITIONS, SEARCHED_AT, CANDIDATES, MATCH = 12, 5 * 4, 4 * 4, 4  # bytes; POSITIONS: x, y and z
TREE = 16 + 384 / 256  # bytes of leaves and nodes per target point, as many as source points

KEPT = Work("match, every match kept", POSITIONS + 16 + 4 + POSITIONS + MATCH, 2 * MOVE + 3 * DISTANCE + 25, POINT_SUMS)
SEARCHED = Work("match, every match searched for", POSITIONS + TREE + SEARCHED_AT + CANDIDATES + MATCH,
                2 * MOVE + DISTANCE + SEARCH + 40, POINT_SUMS)
ACCUMULATE = Work("accumulate", POSITIONS + MATCH + POSITIONS, MOVE + DISTANCE, POINT_SUMS)
LISTED = Work("listed_sums", 2 * POSITIONS, 0, POINT_SUMS - 2)
PLANES = Work("system_sums, planes", POSITIONS + MATCH + POSITIONS + 16, MOVE, PLANE_SUMS)
GENERALIZED = Work("system_sums, GICP", POSITIONS + MATCH + POSITIONS + 32 + 24, MOVE, GENERALIZED_SUMS)
NEAREST = Work("nearest, k = 20", POSITIONS + TREE + 20 * 8, 16 * (2 * NODES * BOX + 3 * LEAVES * (DISTANCE + 160)), 0)
KERNELS = (KEPT, SEARCHED, ACCUMULATE, LISTED, PLANES, GENERALIZED, NEAREST)

# Kernels that make one pass over the points, launches and waits of the host.
ITERATIONS = {
    "to points, every match kept": ((KEPT,), 2, 1),
    "to points, every match searched for": ((SEARCHED,), 2, 1),
    "to planes, every match kept": ((KEPT, PLANES), 4, 2),
    "GICP, every match kept": ((KEPT, GENERALIZED), 4, 2),
}


def microseconds(work, gpu, points):
    """The longest of moving and computing, as if the others hid behind it."""
    sums_rate = gpu.double_rate or gpu.float_rate
    floats = work.float_operations / gpu.float_rate
    sums = work.sum_operations / sums_rate if gpu.double_rate else 0
    if not gpu.double_rate:
        floats += work.sum_operations / sums_rate
    return max(work.moved / gpu.memory, floats, sums) * points / 1e3


def document():
    yield "## Prediction: what an iteration costs at least"
    yield ""
    yield "Not measured. Bytes and operations per point, from the kernels by hand; caches hold what is read twice."
    yield ""
    yield "| kernel | bytes | operations in float | in the sums' precision |"
    yield "|---|---|---|---|"
    for work in KERNELS:
        yield f"| {work.kernel} | {work.moved:.0f} | {work.float_operations:.0f} | {work.sum_operations:.0f} |"
    yield ""
    yield "The time of an iteration by the rates that the makers publish: the longest of moving, computing in float and adding"
    yield f"in double (in float on GPUs without it), and {LAUNCH} us for each launch and wait. Real GPUs take longer: work-items"
    yield "that walk a tree wait for memory and for one another, and `match_solve` adds up a sum of each 256 points one after"
    yield "another."
    yield ""
    yield "| GPU | published: GB/s, Tflop/s in float, in double | iteration | " + " | ".join(
        f"{points // 1000}k points: MB | ms" for points in POINTS) + " |"
    yield "|---|---|---|" + "---|---|" * len(POINTS)
    for gpu in GPUS:
        double = f"{gpu.double_rate / 1e3:.2g}" if gpu.double_rate else "none"
        for name, (passes, launches, waits) in ITERATIONS.items():
            cells = [gpu.name, f"{gpu.memory:.0f}, {gpu.float_rate / 1e3:.3g}, {double}", name]
            for points in POINTS:
                total = sum(microseconds(work, gpu, points) for work in passes) + LAUNCH * (launches + waits)
                cells += [f"{sum(work.moved for work in passes) * points / 1e6:.0f}", f"{total / 1e3:.3f}"]
            yield "| " + " | ".join(cells) + " |"
