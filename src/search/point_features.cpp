#include "point_features.h"

#include "geometry/vector.h"
#include "place_grid.h"

#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_gpu_icp::search {

namespace {

using Vector = std::array<double, 3>;
using Histogram = decltype(PointFeature::histogram);

constexpr std::size_t bins = PointFeature::bins;

// The histograms of the three angles, one after the other. Those of two change sign with the normals.
constexpr std::size_t across = 0, along = bins, about = 2 * bins;

/// \param share from 0 to 1 of the range of the angle
std::size_t binOf(double share) { return std::min(static_cast<std::size_t>(std::max(share, 0.0) * bins), bins - 1); }

/// As with the normals' other signs.
Histogram mirrored(const Histogram& histogram)
{
  Histogram result = histogram;
  for (const std::size_t angle : {along, about})
    std::reverse(result.begin() + angle, result.begin() + angle + bins);
  return result;
}

std::vector<Vector> placesOf(const std::vector<PlacedPoint>& points)
{
  std::vector<Vector> places;
  places.reserve(points.size());
  for (const PlacedPoint& point : points)
    places.push_back({point.xyz[0], point.xyz[1], point.xyz[2]});
  return places;
}

class FeatureEstimation {
public:
  /// \param grid of the places, for the radius
  FeatureEstimation(const std::vector<PlacedPoint>& points,
                    const std::vector<Vector>& places,
                    const std::vector<std::array<float, 3>>& normals,
                    double radius,
                    const PlaceGrid& grid)
  : points_(points)
  , places_(places)
  , normals_(normals)
  , radius_(radius)
  , grid_(grid)
  {
  }

  bool hasNormal(std::size_t i) const { return !std::isnan(normals_[i][0]); }

  /// Of the pairs of the point and each of its neighbours (SPFH).
  PointFeature ofPairs(std::size_t i) const
  {
    constexpr double half_pi = 1.57079632679489661923;
    PointFeature feature;
    if (!hasNormal(i))
      return feature;
    const Vector normal = normalOf(i);
    Histogram& histogram = feature.histogram;
    std::size_t count = 0;
    forEachNeighbour(i, [&](std::size_t neighbour, const Vector& offset, double squared_distance) {
      Vector other = normalOf(neighbour);
      if (dot(other, normal) < 0)
        other = {-other[0], -other[1], -other[2]};
      const double length = std::sqrt(squared_distance);
      const Vector direction{offset[0] / length, offset[1] / length, offset[2] / length};
      Vector v = cross(direction, normal);
      const double sine = std::sqrt(dot(v, v));
      constexpr double parallel = 1e-6;
      if (sine < parallel)
        return;
      for (double& x : v)
        x /= sine;
      const Vector w = cross(normal, v);
      ++histogram[across + binOf((dot(v, other) + 1) / 2)];
      ++histogram[along + binOf((dot(normal, direction) + 1) / 2)];
      ++histogram[about + binOf((std::atan2(dot(w, other), dot(normal, other)) / half_pi + 1) / 2)];
      ++count;
    });
    feature.is_known = count > 0;
    for (float& x : histogram)
      x /= static_cast<float>(std::max<std::size_t>(count, 1));
    return feature;
  }

  /// Of the neighbourhood as a whole (FPFH).
  PointFeature ofNeighbourhood(std::size_t i, const std::vector<PointFeature>& of_pairs) const
  {
    PointFeature feature = of_pairs[i];
    if (!feature.is_known)
      return feature;
    const Vector normal = normalOf(i);
    std::array<double, 3 * bins> sum{};
    double weights = 0;
    forEachNeighbour(i, [&](std::size_t neighbour, const Vector& /*offset*/, double squared_distance) {
      if (!of_pairs[neighbour].is_known)
        return;
      const double weight = 1 / squared_distance;
      const Histogram& own = of_pairs[neighbour].histogram;
      const Histogram histogram = dot(normalOf(neighbour), normal) < 0 ? mirrored(own) : own;
      for (std::size_t bin = 0; bin < sum.size(); ++bin)
        sum[bin] += weight * histogram[bin];
      weights += weight;
    });
    if (weights > 0)
      for (std::size_t bin = 0; bin < sum.size(); ++bin)
        feature.histogram[bin] += static_cast<float>(sum[bin] / weights);
    constexpr double middle = (bins - 1) / 2.0;
    double side = 0;
    for (std::size_t bin = 0; bin < bins; ++bin)
      side += (static_cast<double>(bin) - middle) * feature.histogram[along + bin];
    if (side < 0)
      feature.histogram = mirrored(feature.histogram);
    return feature;
  }

private:
  Vector normalOf(std::size_t i) const { return {normals_[i][0], normals_[i][1], normals_[i][2]}; }

  /// Of those that have a normal.
  template <typename Use>
  void forEachNeighbour(std::size_t i, const Use& use) const
  {
    for (const std::uint32_t other : grid_.near(points_[i].xyz)) {
      const Vector offset{
          places_[other][0] - places_[i][0], places_[other][1] - places_[i][1], places_[other][2] - places_[i][2]};
      const double squared_distance = dot(offset, offset);
      if (squared_distance > 0 && squared_distance <= radius_ * radius_ && hasNormal(other))
        use(other, offset, squared_distance);
    }
  }

  const std::vector<PlacedPoint>& points_;
  const std::vector<Vector>& places_;
  const std::vector<std::array<float, 3>>& normals_;
  double radius_;
  const PlaceGrid& grid_;
};

constexpr std::size_t of_a_range = 64;
constexpr std::size_t none = ~std::size_t(0);

struct Nearest {
  std::size_t place = none;
  float squared_distance = std::numeric_limits<float>::infinity();
  float next_squared_distance = std::numeric_limits<float>::infinity();

  /// Where a cloud is symmetric several are as near, and none is the one.
  bool isTheOne() const
  {
    constexpr float rounding = 1e-6F;
    return next_squared_distance > squared_distance + rounding;
  }
};

/// Of each of the features the nearest known one of others.
std::vector<Nearest>
nearestOf(const std::vector<PointFeature>& features, const std::vector<PointFeature>& others, unsigned threads)
{
  // A row for each bin, so that the compiler's vectors are of others.
  const std::size_t count = others.size();
  std::vector<float> rows(3 * bins * count);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t bin = 0; bin < 3 * bins; ++bin)
      rows[bin * count + i] = others[i].is_known ? others[i].histogram[bin] : std::numeric_limits<float>::infinity();
  std::vector<Nearest> nearest(features.size());
  parallelFor(features.size(), of_a_range, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<float> squared(count);
    for (std::size_t i = begin; i < end; ++i) {
      if (!features[i].is_known)
        continue;
      std::fill(squared.begin(), squared.end(), 0.0F);
      for (std::size_t bin = 0; bin < 3 * bins; ++bin) {
        const float own = features[i].histogram[bin];
        const float* row = rows.data() + bin * count;
        float* sums = squared.data();
        for (std::size_t j = 0; j < count; ++j)
          sums[j] += (row[j] - own) * (row[j] - own);
      }
      for (std::size_t j = 0; j < count; ++j)
        if (squared[j] < nearest[i].squared_distance)
          nearest[i] = {j, squared[j], nearest[i].squared_distance};
        else
          nearest[i].next_squared_distance = std::min(nearest[i].next_squared_distance, squared[j]);
    }
  });
  return nearest;
}

} // namespace

std::vector<PointFeature> pointFeatures(const std::vector<PlacedPoint>& points,
                                        const std::vector<std::array<float, 3>>& normals,
                                        double radius,
                                        unsigned threads)
{
  const std::vector<Vector> places = placesOf(points);
  const PlaceGrid grid(places, radius);
  const FeatureEstimation estimation(points, places, normals, radius, grid);
  const auto ofEach = [&](const auto& featureOf) {
    std::vector<PointFeature> features(points.size());
    parallelFor(points.size(), of_a_range, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        features[i] = featureOf(i);
    });
    return features;
  };
  const auto of_pairs = ofEach([&](std::size_t i) { return estimation.ofPairs(i); });
  return ofEach([&](std::size_t i) { return estimation.ofNeighbourhood(i, of_pairs); });
}

std::vector<FeatureMatch> mutualMatches(const std::vector<PointFeature>& source,
                                        const std::vector<PointFeature>& target,
                                        std::size_t most,
                                        unsigned threads)
{
  const std::vector<Nearest> of_source = nearestOf(source, target, threads),
                             of_target = nearestOf(target, source, threads);
  std::vector<FeatureMatch> matches;
  for (std::size_t i = 0; i < of_source.size(); ++i)
    if (of_source[i].place != none && of_source[i].isTheOne() && of_target[of_source[i].place].place == i &&
        of_target[of_source[i].place].isTheOne())
      matches.push_back({i, of_source[i].place});
  const auto bySource = [](const FeatureMatch& a, const FeatureMatch& b) { return a.source < b.source; };
  if (matches.size() > most) {
    std::stable_sort(matches.begin(), matches.end(), [&](const FeatureMatch& a, const FeatureMatch& b) {
      return of_source[a.source].squared_distance < of_source[b.source].squared_distance;
    });
    matches.resize(most);
    std::sort(matches.begin(), matches.end(), bySource);
  }
  return matches;
}

} // namespace pcl_gpu_icp::search
