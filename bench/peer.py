"""A peer's method on one pair of clouds, in a process of its own: peer.py METHOD SOURCE TARGET ITERATIONS [converge|window].
Or METHODS[name]() is asked for align(source, target, iterations, epsilon, limit), which returns a 4x4 matrix and iterations: it
ends at a step of `epsilon` metres and 100 times as many degrees, takes no pair farther apart than `limit`.

Clouds are raw float32 triples. Prints a line of JSON as align_benchmark does. The trees, and the normals or covariances
that a method needs, are part of the time."""

import json
import resource
import sys
import time

import numpy


def small_gicp_method(kind, threads):
    import small_gicp

    def prepare(points):
        cloud = small_gicp.PointCloud(points)
        tree = small_gicp.KdTree(cloud, num_threads=threads)
        if kind == "PLANE_ICP":
            small_gicp.estimate_normals(cloud, tree, num_neighbors=10, num_threads=threads)
        elif kind == "GICP":
            small_gicp.estimate_covariances(cloud, tree, num_neighbors=10, num_threads=threads)
        return cloud, tree

    kept = {}

    def align(source, target, iterations, epsilon, limit=1e3):
        if kept.get("points") is not target:
            kept.update(points=target, prepared=prepare(target))
        target_cloud, tree = kept["prepared"]
        source_cloud, _ = prepare(source) if kind == "GICP" else (small_gicp.PointCloud(source), None)
        result = small_gicp.align(
            target_cloud,
            source_cloud,
            tree,
            registration_type=kind,
            max_correspondence_distance=limit,
            num_threads=threads,
            max_iterations=iterations,
            rotation_epsilon=numpy.radians(100 * epsilon),
            translation_epsilon=epsilon,
        )
        return result.T_target_source, result.iterations

    return align


def open3d_method(plane):
    import open3d

    def cloud_of(points):
        return open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))

    def align(source, target, iterations, epsilon, limit=1e3):
        registration = open3d.pipelines.registration
        source_cloud, target_cloud = cloud_of(source), cloud_of(target)
        if plane:
            target_cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(10))
            estimation = registration.TransformationEstimationPointToPlane()
        else:
            estimation = registration.TransformationEstimationPointToPoint()
        relative = epsilon / 10  # Its criteria are the relative changes of fitness and RMSE.
        result = registration.registration_icp(
            source_cloud,
            target_cloud,
            limit,
            numpy.eye(4),
            estimation,
            registration.ICPConvergenceCriteria(relative, relative, iterations),
        )
        return result.transformation, None

    return align


METHODS = {
    "small_gicp ICP": lambda: small_gicp_method("ICP", 2),
    "small_gicp point-to-plane": lambda: small_gicp_method("PLANE_ICP", 2),
    "small_gicp GICP": lambda: small_gicp_method("GICP", 2),
    "Open3D ICP": lambda: open3d_method(False),
    "Open3D point-to-plane": lambda: open3d_method(True),
}


def main():
    method, source, target, iterations = sys.argv[1:5]
    mode = sys.argv[5] if len(sys.argv) > 5 else None
    align = METHODS[method]()
    source, target = (
        numpy.fromfile(path, dtype=numpy.float32).reshape(-1, 3).astype(numpy.float64) for path in (source, target)
    )
    sources = [source[first::10] for first in range(10)] if mode == "window" else [source]
    epsilon = 1e-3 if mode == "converge" else 0.0
    align(source, target, int(iterations), epsilon)
    target = target.copy()  # Nothing is known of it from the run before.
    each = []
    for source in sources:
        start = time.perf_counter()
        transform, done = align(source, target, int(iterations), epsilon)
        each.append(1e3 * (time.perf_counter() - start))
    result = {
        "ms": sum(each),
        "each_ms": each,
        "transform": numpy.asarray(transform).tolist(),
        "peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }
    if done is not None:
        result["iterations"] = done
    print(json.dumps(result))


if __name__ == "__main__":
    main()
