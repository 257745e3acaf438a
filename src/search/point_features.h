#pragma once

#include <pcl_gpu_icp/points.h>

#include <array>
#include <cstddef>
#include <vector>

namespace pcl_gpu_icp::search {

/// How the surface lies around a point, whatever the cloud's pose: a Fast Point Feature Histogram (Rusu et al. 2009,
/// pcl::FPFHEstimation) that does not depend on the signs of the normals. Theirs are made to agree around each point,
/// and the one of two mirrored histograms is taken of which most neighbours lie on the normal's side.
struct PointFeature {
  static constexpr std::size_t bins = 11; ///< of each of three angles

  std::array<float, 3 * bins> histogram{};
  bool is_known = false; ///< the point has a normal and neighbours that have one
};

/// \param normals unit vectors, as many as there are points; NaN: there is none
/// \param threads on the host; the same bits for any number
std::vector<PointFeature> pointFeatures(const std::vector<PlacedPoint>& points,
                                        const std::vector<std::array<float, 3>>& normals,
                                        double radius,
                                        unsigned threads);

/// A source and a target point, by their place in their clouds, each of whose features is the other's nearest and no
/// other is as near.
struct FeatureMatch {
  std::size_t source, target;
};

/// At most so many, those that are most alike, in the order of the source.
/// \param threads on the host; the same for any number
std::vector<FeatureMatch> mutualMatches(const std::vector<PointFeature>& source,
                                        const std::vector<PointFeature>& target,
                                        std::size_t most,
                                        unsigned threads);

} // namespace pcl_gpu_icp::search
