#include "cli/cloud_pair.h"

#include "cli/cloud_file.h"
#include "cli/guess.h"

#include <limits>

namespace pcl_gpu_icp::cli {

RigidTransform CloudPair::inFileCoordinates(const RigidTransform& transform) const
{
  std::array<double, 3> from;
  std::array<double, 3> to;
  for (int i = 0; i < 3; ++i) {
    from[i] = -source.origin[i];
    to[i] = -target.origin[i];
  }
  return recentred(transform, from, to);
}

void describe(report::AlignmentReport& report, const CloudPair& pair, const RigidTransform& transform)
{
  report.transform = pair.inFileCoordinates(transform);
  report.resolution = pair.source.extent * std::numeric_limits<float>::epsilon();
  report.source_points = pair.source.counts;
  report.target_points = pair.target.counts;
  report.target_points.coincident = report.result.target_dropped;
  report.target_points.used = report.result.target_points;
}

CloudPair readPair(const AlignmentOptions& options)
{
  const RigidTransform guess = options.guess ? readGuess(*options.guess) : RigidTransform();
  CloudPair pair;
  pair.source_file = readCloud(options.source);
  pair.source = prepare(pair.source_file, options.source, options);
  pair.target = prepare(readCloud(options.target), options.target, options);
  pair.guess = recentred(orthonormalised(guess, pair.source.centroid), pair.source.origin, pair.target.origin);
  return pair;
}

} // namespace pcl_gpu_icp::cli
