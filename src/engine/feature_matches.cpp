#include "feature_matches.h"

#include "geometry/quaternion.h"
#include "geometry/rotation_vector.h"
#include "geometry/vector.h"
#include "search/point_features.h"
#include "search/voxels.h"
#include "symmetric_eigen.h"
#include "thin_target.h"

#include <pcl_gpu_icp/normal_estimator.h>
#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace pcl_gpu_icp {

namespace {

using Vector = std::array<double, 3>;

Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// Between lines, in radians.
double angle(const Vector& a, const Vector& b) { return std::acos(std::min(std::abs(dot(a, b)), 1.0)); }

/// The size of voxels that tell enough of both clouds, and of which comparing each with each takes no time.
double voxelSizeOf(const std::vector<PlacedPoint>& source, const std::vector<PlacedPoint>& target)
{
  constexpr std::size_t of_source = 3000, of_target = 6000;
  constexpr double fewest_each = 1.25;
  return std::max(search::voxelSizeFor(source, of_source, fewest_each),
                  search::voxelSizeFor(target, of_target, fewest_each));
}

std::vector<PlacedPoint> movedBy(const RigidTransform& motion, std::vector<PlacedPoint> points)
{
  for (PlacedPoint& point : points) {
    const Vector moved = motion(point.xyz[0], point.xyz[1], point.xyz[2]);
    std::transform(moved.begin(), moved.end(), point.xyz, [](double x) { return static_cast<float>(x); });
  }
  return points;
}

/// Means of voxels that lie askew to those of another cloud: what a grid makes of a copy is else the same pattern, and
/// would say of a cube which of its faces is which.
std::vector<PlacedPoint> askewMeans(const std::vector<PlacedPoint>& points, double size)
{
  RigidTransform turn;
  turn.rotation = rotationBy({0.4, 0.7, 1.1});
  return movedBy(inverse(turn), search::voxelMeans(movedBy(turn, points), size));
}

/// Sets of matches, a bit each.
class MatchSets {
public:
  explicit MatchSets(std::size_t count)
  : words_((count + 63) / 64)
  , bits_(count * words_)
  {
  }

  void add(std::size_t set, std::size_t match) { bits_[set * words_ + match / 64] |= std::uint64_t(1) << match % 64; }

  bool holds(std::size_t set, std::size_t match) const
  {
    return (bits_[set * words_ + match / 64] >> match % 64 & 1) != 0;
  }

  std::size_t inBoth(std::size_t a, std::size_t b) const
  {
    std::size_t count = 0;
    for (std::size_t word = 0; word < words_; ++word)
      count += bitsOf(bits_[a * words_ + word] & bits_[b * words_ + word]);
    return count;
  }

private:
  /// The processor that everybody has knows no instruction for it (Warren, Hacker's Delight, 5-1).
  static std::size_t bitsOf(std::uint64_t x)
  {
    x -= x >> 1 & 0x5555555555555555;
    x = (x & 0x3333333333333333) + (x >> 2 & 0x3333333333333333);
    return ((x + (x >> 4)) & 0x0F0F0F0F0F0F0F0F) * 0x0101010101010101 >> 56;
  }

  std::size_t words_;
  std::vector<std::uint64_t> bits_;
};

/// The rigid transform of least squares (Horn 1987: the quaternion is an eigenvector).
template <typename Matches>
RigidTransform bestTransform(const Matches& matches)
{
  Vector from{}, to{};
  for (const auto& match : matches)
    for (int axis = 0; axis < 3; ++axis) {
      from[axis] += match.source.place[axis] / static_cast<double>(matches.size());
      to[axis] += match.target.place[axis] / static_cast<double>(matches.size());
    }
  double s[3][3] = {};
  for (const auto& match : matches) {
    const Vector a = match.source.place - from, b = match.target.place - to;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        s[row][column] += a[row] * b[column];
  }
  SquareMatrix<4> n{{{s[0][0] + s[1][1] + s[2][2], s[1][2] - s[2][1], s[2][0] - s[0][2], s[0][1] - s[1][0]},
                     {0, s[0][0] - s[1][1] - s[2][2], s[0][1] + s[1][0], s[2][0] + s[0][2]},
                     {0, 0, s[1][1] - s[0][0] - s[2][2], s[1][2] + s[2][1]},
                     {0, 0, 0, s[2][2] - s[0][0] - s[1][1]}}};
  for (std::size_t row = 0; row < 4; ++row)
    for (std::size_t column = 0; column < row; ++column)
      n[row][column] = n[column][row];
  const SquareMatrix<4> vectors = diagonalise(n);
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i)
    if (n[i][i] > n[largest][largest])
      largest = i;
  RigidTransform result;
  result.rotation = rotationOf({vectors[0][largest], vectors[1][largest], vectors[2][largest], vectors[3][largest]});
  result.translation = to - result(from[0], from[1], from[2]);
  return result;
}

constexpr std::size_t fewest_matches = 3; ///< that determine a pose

} // namespace

FeatureMatches::FeatureMatches(const Device& device,
                               const std::vector<PlacedPoint>& source_points,
                               const std::vector<PlacedPoint>& target_points,
                               const std::shared_ptr<DeviceShare>& share)
: voxel_(voxelSizeOf(source_points, target_points))
{
  constexpr double radius = 6; // voxels
  constexpr std::size_t matches_at_most = 800;
  if (!(voxel_ > 0))
    return;
  const auto source = search::voxelMeans(source_points, voxel_), target = askewMeans(target_points, voxel_);
  const unsigned threads = share ? 1 : effectiveThreads(0);
  NormalEstimator estimator(device, Precision::Float);
  estimator.setShare(share);
  const auto source_normals = estimator.estimate(viewOf(source)), target_normals = estimator.estimate(viewOf(target));
  const auto featuresOf = [&](const auto& points, const auto& normals) {
    return search::pointFeatures(points, normals, radius * voxel_, threads);
  };
  const auto surfacePoint = [](const PlacedPoint& point, const std::array<float, 3>& normal) {
    return SurfacePoint{{point.xyz[0], point.xyz[1], point.xyz[2]}, {normal[0], normal[1], normal[2]}};
  };
  for (const search::FeatureMatch& match : search::mutualMatches(
           featuresOf(source, source_normals), featuresOf(target, target_normals), matches_at_most, threads))
    matches_.push_back({surfacePoint(source[match.source], source_normals[match.source]),
                        surfacePoint(target[match.target], target_normals[match.target])});
  for (const Match& match : matches_)
    for (int axis = 0; axis < 3; ++axis)
      centre_[axis] += match.source.place[axis] / static_cast<double>(matches_.size());
}

std::vector<FeatureMatches::Match> FeatureMatches::agreeing(const RigidTransform& pose, double near) const
{
  constexpr double along = 0.8;
  RigidTransform turn = pose;
  turn.translation = {};
  std::vector<Match> result;
  for (const Match& match : matches_) {
    const auto& [place, normal] = match.source;
    if (distance(pose(place[0], place[1], place[2]), match.target.place) < near * voxel_ &&
        std::abs(dot(turn(normal[0], normal[1], normal[2]), match.target.normal)) > along)
      result.push_back(match);
  }
  return result;
}

std::size_t FeatureMatches::support(const RigidTransform& pose) const { return agreeing(pose).size(); }

RigidTransform FeatureMatches::fitted(const RigidTransform& pose) const
{
  constexpr std::size_t enough = 10; // to be more exact than what they come of
  constexpr int steps = 5;
  constexpr double close = 1.5; // voxels
  RigidTransform fit = pose;
  for (const double near : {agreeing_voxels, 2.0, close})
    for (int step = 0; step < steps; ++step) {
      const std::vector<Match> agreed = agreeing(fit, near);
      if (agreed.size() >= enough)
        fit = bestTransform(agreed);
    }
  const auto before = static_cast<double>(agreeing(pose, close).size());
  const auto after = static_cast<double>(agreeing(fit, close).size());
  return after > before + std::sqrt(before) ? fit : pose; // more than by chance
}

/// Whether one pose could put both on each other: as far apart in both clouds, with normals that lie alike.
bool FeatureMatches::areCompatible(const Match& a, const Match& b) const
{
  constexpr double near = 3, as_far = 2; // voxels
  constexpr double alike = 0.4;          // radians
  const Vector in_source = a.source.place - b.source.place, in_target = a.target.place - b.target.place;
  const double source_length = std::sqrt(dot(in_source, in_source)),
               target_length = std::sqrt(dot(in_target, in_target));
  if (std::abs(source_length - target_length) > as_far * voxel_ ||
      std::min(source_length, target_length) < near * voxel_)
    return false;
  const auto areAlike = [](double source_angle, double target_angle) {
    return std::abs(source_angle - target_angle) < alike;
  };
  const auto toLine = [](const SurfacePoint& point, const Vector& line, double length) {
    return std::acos(std::min(std::abs(dot(point.normal, line)) / length, 1.0));
  };
  return areAlike(angle(a.source.normal, b.source.normal), angle(a.target.normal, b.target.normal)) &&
         areAlike(toLine(a.source, in_source, source_length), toLine(a.target, in_target, target_length)) &&
         areAlike(toLine(b.source, in_source, source_length), toLine(b.target, in_target, target_length));
}

// Two matches of one pose share most of those that either is compatible with; others share few (Chen et al., SC2-PCR,
// CVPR 2022).
std::vector<RigidTransform> FeatureMatches::poses(std::size_t most) const
{
  constexpr std::size_t seeds_at_most = 100, of_a_seed = 10;
  const std::size_t count = matches_.size();
  MatchSets compatible(count);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (areCompatible(matches_[i], matches_[j])) {
        compatible.add(i, j);
        compatible.add(j, i);
      }
  struct Ranked {
    std::size_t match, in_common;
  };
  const auto ranked = [&](std::size_t seed) {
    std::vector<Ranked> others;
    for (std::size_t i = 0; i < count; ++i)
      if (compatible.holds(seed, i))
        others.push_back({i, compatible.inBoth(seed, i)});
    return others;
  };
  const auto byCommon = [](const Ranked& a, const Ranked& b) { return a.in_common > b.in_common; };
  std::vector<Ranked> seeds;
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<Ranked> others = ranked(i);
    const auto closest = std::min_element(others.begin(), others.end(), byCommon);
    if (closest != others.end())
      seeds.push_back({i, closest->in_common});
  }
  std::stable_sort(seeds.begin(), seeds.end(), byCommon);
  seeds.resize(std::min(seeds.size(), seeds_at_most));

  struct Supported {
    RigidTransform pose;
    std::size_t support;
  };
  std::vector<Supported> found;
  for (const Ranked& seed : seeds) {
    std::vector<Ranked> others = ranked(seed.match);
    std::stable_sort(others.begin(), others.end(), byCommon);
    std::vector<std::size_t> set{seed.match};
    for (const Ranked& other : others)
      if (set.size() <= of_a_seed && std::all_of(set.begin(), set.end(), [&](std::size_t member) {
            return compatible.holds(member, other.match);
          }))
        set.push_back(other.match);
    if (set.size() < fewest_matches)
      continue;
    std::vector<Match> agreed;
    agreed.reserve(set.size());
    for (const std::size_t member : set)
      agreed.push_back(matches_[member]);
    constexpr int refinements = 2;
    RigidTransform pose;
    for (int step = 0; step <= refinements && agreed.size() >= fewest_matches; ++step) {
      pose = bestTransform(agreed);
      agreed = agreeing(pose);
    }
    if (agreed.size() >= fewest_matches)
      found.push_back({pose, agreed.size()});
  }
  std::stable_sort(
      found.begin(), found.end(), [](const Supported& a, const Supported& b) { return a.support > b.support; });

  constexpr double near_angle = 0.17, near_voxels = 6; // 10 degrees
  const auto placed = [&](const RigidTransform& pose) { return pose(centre_[0], centre_[1], centre_[2]); };
  std::vector<RigidTransform> distinct;
  for (const Supported& each : found)
    if (distinct.size() < most && std::none_of(distinct.begin(), distinct.end(), [&](const RigidTransform& kept) {
          return angleBetween(each.pose, kept) < near_angle &&
                 distance(placed(each.pose), placed(kept)) < near_voxels * voxel_;
        }))
      distinct.push_back(each.pose);
  return distinct;
}

} // namespace pcl_gpu_icp
