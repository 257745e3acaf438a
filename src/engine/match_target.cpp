#include "match_target.h"

#include "search/box_tree.h"
#include "search/bulk.h"

#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_gpu_icp {

namespace {

static_assert(search::Neighbourhood::most == KEPT_CANDIDATES, "what the host finds is what the device keeps");

float roundingOf(const std::vector<PlacedPoint>& points, const std::array<double, 3>& pivot)
{
  const auto largest = search::Bulk(viewOf(points)).largest(viewOf(points), pivot);
  return static_cast<float>(*std::max_element(largest.begin(), largest.end()) * std::numeric_limits<float>::epsilon() /
                            2);
}

} // namespace

void PlacedCloud::place(const Points& cloud, unsigned threads)
{
  pivot = search::pivotOf(cloud);
  points = search::finitePoints(cloud, pivot, threads);
  rounding = roundingOf(points, pivot);
}

void PlacedCloud::place(const search::NearestIndex& index)
{
  pivot = index.pivot();
  points = index.points();
  rounding = roundingOf(points, pivot);
}

void MatchTarget::searchIndex(const stages::SearchEffort& effort,
                              unsigned threads,
                              const stages::Query* queries,
                              std::size_t count,
                              cl_int* positions,
                              float* reaches) const
{
  parallelFor(count, search::queries_at_a_time, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t j = begin; j < end; ++j) {
      const auto neighbours = index->neighbourhood(queries[j].xyz, queries[j].radius_sq, effort.slack, effort.kept);
      for (std::size_t k = 0; k < KEPT_CANDIDATES; ++k)
        positions[j + k * count] = neighbours.rows[k];
      // Beyond what can be told from infinite nothing is known.
      const float bound_sq = std::min(neighbours.bound_sq, std::numeric_limits<float>::max());
      reaches[j] = std::sqrt(std::min(neighbours.squared_distances[1], bound_sq));
      reaches[j + count] = std::sqrt(bound_sq);
    }
  });
}

} // namespace pcl_gpu_icp
