"""A peer's search from anywhere: search_peer.py METHOD VOXEL, on pairs from standard input as search_benchmark takes them.

Clouds are thinned to the voxels already. Features, and the normals that they need, are part of the time."""

import json
import sys
import time

import numpy


def kiss_matcher_method(voxel):
    import kiss_matcher

    def search(source, target):
        matcher = kiss_matcher.KISSMatcher(kiss_matcher.KISSMatcherConfig(voxel))
        result = matcher.estimate(source, target)
        transform = numpy.eye(4)
        transform[:3, :3] = result.rotation
        transform[:3, 3] = numpy.ravel(result.translation)
        return transform

    return search


def open3d_method(voxel, fast):
    import open3d

    registration = open3d.pipelines.registration

    # Radii and criteria are those of Open3D's tutorial on global registration.
    def prepared(points):
        cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
        cloud.estimate_normals(open3d.geometry.KDTreeSearchParamHybrid(2 * voxel, 30))
        return cloud, registration.compute_fpfh_feature(cloud, open3d.geometry.KDTreeSearchParamHybrid(5 * voxel, 100))

    def search(source, target):
        clouds_and_features = prepared(source), prepared(target)
        (source_cloud, target_cloud), (source_features, target_features) = zip(*clouds_and_features)
        if fast:
            return registration.registration_fgr_based_on_feature_matching(
                source_cloud,
                target_cloud,
                source_features,
                target_features,
                registration.FastGlobalRegistrationOption(maximum_correspondence_distance=0.5 * voxel),
            ).transformation
        return registration.registration_ransac_based_on_feature_matching(
            source_cloud,
            target_cloud,
            source_features,
            target_features,
            True,
            1.5 * voxel,
            registration.TransformationEstimationPointToPoint(False),
            3,
            [
                registration.CorrespondenceCheckerBasedOnEdgeLength(0.9),
                registration.CorrespondenceCheckerBasedOnDistance(1.5 * voxel),
            ],
            registration.RANSACConvergenceCriteria(100000, 0.999),
        ).transformation

    return search


METHODS = {
    "KISS-Matcher": kiss_matcher_method,
    "Open3D RANSAC": lambda voxel: open3d_method(voxel, False),
    "Open3D FGR": lambda voxel: open3d_method(voxel, True),
}


def main():
    search = METHODS[sys.argv[1]](float(sys.argv[2]))
    for line in sys.stdin:
        source, target = (
            numpy.fromfile(path, dtype=numpy.float32).reshape(-1, 3).astype(numpy.float64) for path in line.split()
        )
        start = time.perf_counter()
        transform = search(source, target)
        milliseconds = 1e3 * (time.perf_counter() - start)
        # Peers print notes of their own to standard output.
        print("\n" + json.dumps({"ms": milliseconds, "transform": numpy.asarray(transform).tolist()}), flush=True)


if __name__ == "__main__":
    main()
