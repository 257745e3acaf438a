#include "system_increment.h"

#include "loss_internals.h"
#include "point_pairs.h"
#include "search/bulk.h"
#include "solution.h"
#include "symmetric_eigen.h"
#include "uncertainty_internals.h"
#include "values_at.h"

#include <pcl_gpu_icp/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace pcl_gpu_icp {

namespace {

template <typename real>
std::array<double, SYSTEM_SUMS> download(opencl::Queue& queue, const opencl::Buffer& total)
{
  std::array<double, SYSTEM_SUMS> sums{};
  queue.download(total, SYSTEM_SUMS * sizeof(real), [&](const void* memory) {
    const auto* values = static_cast<const real*>(memory);
    std::copy(values, values + SYSTEM_SUMS, sums.begin());
  });
  return sums;
}

/// `width` floats of each of the caller's points, in the order of the leaves.
template <std::size_t width>
std::vector<std::array<float, width>> inOrder(const std::vector<PlacedPoint>& target, const Points& values)
{
  std::vector<std::array<float, width>> in_order(target.size());
  for (std::size_t i = 0; i < target.size(); ++i) {
    const float* value = valuesAt(values, target[i].position);
    std::copy(value, value + width, in_order[i].begin());
  }
  return in_order;
}

/// What of the information of two points with such a covariance is along the direction that it is greatest in.
double tangentialShare(const stages::Covariance& c)
{
  SquareMatrix<3> matrix{{{c[0], c[1], c[2]}, {c[1], c[3], c[4]}, {c[2], c[4], c[5]}}};
  diagonalise(matrix);
  const double greatest = std::max({matrix[0][0], matrix[1][1], matrix[2][2]});
  if (!(greatest > 0)) // a point without any: all directions are the same
    return 1.0 / 3;
  constexpr double flattest = 1e-6; // of what float32 holds
  double sum = 0;
  for (int i = 0; i < 3; ++i)
    sum += 1 / std::max(matrix[i][i], flattest * greatest);
  return 1 / (greatest * sum);
}

/// Whether residuals are distances along normals.
bool isAcross(Metric metric) { return metric == Metric::Plane || metric == Metric::Symmetric; }

/// Of the increment, in the frame that it is estimated in.
RigidTransform motionOf(const Estimate& estimate) { return {estimate.stages.R, estimate.stages.t}; }

/// Of a small rotation, in radians.
double angleOf(const RigidTransform& motion)
{
  const auto& R = motion.rotation;
  return std::hypot(R[7] - R[5], R[2] - R[6], R[3] - R[1]) / 2;
}

} // namespace

void SystemIncrement::measureRounding(const std::vector<PlacedPoint>& target, const std::array<double, 3>& pivot)
{
  const auto largest = search::Bulk(viewOf(target)).largest(viewOf(target), pivot);
  for (int axis = 0; axis < 3; ++axis)
    rounding_[axis] = largest[axis] * std::numeric_limits<float>::epsilon() / 2;
}

bool Objective::isPlain() const { return !loss.weighs() && motions == Motions::Rigid; }

void SystemIncrement::setPoints(const std::vector<PlacedPoint>& target, const std::array<double, 3>& pivot)
{
  metric_ = Metric::Point;
  measureRounding(target, pivot);
}

void SystemIncrement::setTargetNormals(opencl::Queue& queue,
                                       const std::vector<PlacedPoint>& target,
                                       const std::array<double, 3>& pivot,
                                       const Points& normals)
{
  metric_ = Metric::Plane;
  measureRounding(target, pivot);
  stages::packTargetNormals(queue, inOrder<NORMAL_ROWS>(target, normals), own_);
}

void SystemIncrement::setSourceNormals(opencl::Queue& queue,
                                       const std::vector<stages::Normal>& in_order,
                                       const stages::SourcePoints& source)
{
  metric_ = Metric::Symmetric;
  stages::packSourceNormals(queue, in_order, source, own_);
  source_surfaces_ = in_order.size();
}

void SystemIncrement::setTargetCovariances(opencl::Queue& queue,
                                           const std::vector<PlacedPoint>& target,
                                           const std::array<double, 3>& pivot,
                                           const Points& covariances)
{
  metric_ = Metric::Generalized;
  measureRounding(target, pivot);
  const auto in_order = inOrder<COVARIANCE_ROWS>(target, covariances);
  stages::packTargetCovariances(queue, in_order, own_);
  constexpr std::size_t samples = 256;
  const std::size_t step = in_order.size() / samples + 1;
  std::vector<double> shares;
  for (std::size_t i = 0; i < in_order.size(); i += step)
    shares.push_back(tangentialShare(in_order[i]));
  const auto middle = shares.begin() + static_cast<std::ptrdiff_t>(shares.size() / 2);
  std::nth_element(shares.begin(), middle, shares.end());
  tangential_ = shares.empty() ? 0 : *middle;
}

void SystemIncrement::setSource(const std::vector<PlacedPoint>& source)
{
  source_points_ = source.size();
  source_surfaces_ = 0;
  lever_ = leverOf(viewOf(source));
}

void SystemIncrement::setSourceCovariances(opencl::Queue& queue,
                                           const std::vector<stages::Covariance>& in_order,
                                           const stages::SourcePoints& source)
{
  stages::packSourceCovariances(queue, in_order, source, own_);
  source_surfaces_ = in_order.size();
}

double SystemIncrement::rowNoise(const System& system) const
{
  // A normal is no better than the points it comes of: their rounding along it, seen from a neighbour.
  const double spacing = surfaceSpacing(system.length, source_points_);
  // The places of sum n n^T's diagonal in the upper triangle of six.
  const double squares[3] = {system.sums[15], system.sums[18], system.sums[20]};
  const double weight = system.weight();
  double along_sq = 0;
  for (int axis = 0; axis < 3; ++axis)
    along_sq += weight > 0 ? squares[axis] / weight * rounding_[axis] * rounding_[axis] : 0;
  return std::hypot(std::sqrt(along_sq) / spacing, std::numeric_limits<float>::epsilon());
}

System SystemIncrement::systemAt(opencl::Queue& queue,
                                 Precision precision,
                                 const stages::SourcePoints& source,
                                 const RigidTransform& pose,
                                 const RigidTransform& turn,
                                 const opencl::Buffer& matches,
                                 const stages::TargetPoints& target,
                                 const Objective& objective,
                                 std::vector<float>* residuals)
{
  const bool is_double = precision == Precision::Double;
  const std::size_t real_bytes = is_double ? sizeof(double) : sizeof(float);
  System system;
  system.motions = objective.motions;
  system.turns_by_halves = metric_ == Metric::Symmetric;
  system.centre = pose(lever_.centre[0], lever_.centre[1], lever_.centre[2]);
  for (double& coordinate : system.centre)
    coordinate = rounded<float>(coordinate);
  system.length = lever_.length > 0 ? lever_.length : 1;

  queue.reserve(total_, SYSTEM_SUMS * real_bytes);
  stage_.enqueue(queue,
                 metric_,
                 source,
                 pose,
                 turn,
                 matches,
                 target,
                 own_,
                 system.centre,
                 objective.loss.weighs() ? objective.loss : Loss{},
                 residuals != nullptr,
                 real_bytes,
                 total_);
  system.sums = is_double ? download<double>(queue, total_) : download<float>(queue, total_);
  requireFinite(system.sums, precision, metric_);
  system.row_noise = rowNoise(system);
  system.sum_noise = 8 * (is_double ? std::numeric_limits<double>::epsilon() : std::numeric_limits<float>::epsilon());
  if (residuals)
    queue.download(stage_.residuals(), source.count * sizeof(float), [&](const void* memory) {
      const auto* values = static_cast<const float*>(memory);
      Sample(source.count).forEach([&](std::size_t i) { residuals->push_back(values[i]); });
    });
  return system;
}

Estimate SystemIncrement::estimate(opencl::Queue& queue,
                                   Precision precision,
                                   const stages::SourcePoints& source,
                                   const RigidTransform& pose,
                                   const opencl::Buffer& matches,
                                   const stages::TargetPoints& target,
                                   const Objective& objective)
{
  // The cost is quadratic in the shift; what a step leaves over is of the order of its angle squared.
  constexpr double linear_angle = 1e-3;

  if (knowsBothSurfaces(metric_) && source_surfaces_ != source_points_)
    throw InvalidArgument("the source's points are " + std::to_string(source_points_) + ", its " +
                          (metric_ == Metric::Symmetric ? "normals " : "covariances ") +
                          std::to_string(source_surfaces_));
  Objective sought = objective;
  if (sought.loss.weighs() && sought.loss.scale == 0) {
    std::vector<float> residuals;
    systemAt(queue, precision, source, pose, pose, matches, target, {{}, objective.motions}, &residuals);
    sought.loss.scale = scaleFrom(residuals, sought.loss.function);
  }
  loss_scale_ = sought.loss.weighs() ? sought.loss.scale : 0;
  System system = systemAt(queue, precision, source, pose, pose, matches, target, sought);
  const double trace = system.unweighedTrace() / (metric_ == Metric::Point ? 3 : 1);
  mean_squared_distance_ = trace > 0 ? system.cost() / trace : 0;
  Estimate step = solved(system);
  if (isAcross(metric_))
    return step;

  const std::array<double, 3> centre = system.centre;
  RigidTransform done; // from the pose to where `system` is of
  double share = 1;
  for (int steps = 1; steps < sought.steps && angleOf(motionOf(step)) > linear_angle; ++steps) {
    const RigidTransform next = compose(motionOf(step), done);
    const System there =
        systemAt(queue, precision, source, inFloat(compose(next, pose)), pose, matches, target, sought);
    const bool better = there.cost() <= system.cost();
    if (better) {
      system = there;
      done = next;
    }
    share = better ? 1 : share / 2;
    step = solved(system, share);
  }
  const RigidTransform motion = compose(motionOf(step), done);
  step.stages.R = motion.rotation;
  step.stages.t = motion.translation;
  step.stages.source_centroid = centre;
  step.stages.target_centroid = motion(centre[0], centre[1], centre[2]);
  return step;
}

std::optional<Uncertainty> SystemIncrement::uncertainty(opencl::Queue& queue,
                                                        Precision precision,
                                                        const stages::SourcePoints& source,
                                                        const RigidTransform& pose,
                                                        const opencl::Buffer& matches,
                                                        const stages::TargetPoints& target,
                                                        const Objective& objective,
                                                        const PointPairs& points,
                                                        double spacing)
{
  Objective sought = objective;
  if (objective.loss.weighs())
    sought.loss.scale = loss_scale_;
  std::vector<float> residuals;
  const System system = systemAt(queue, precision, source, pose, pose, matches, target, sought, &residuals);
  double robust = robustDeviation(residuals);
  const auto pairs = static_cast<double>(residuals.size() * Sample(source.count).each());
  // A plane's residual is one number, and so nearly is GICP's, which the direction across the surface makes up.
  const double numbers = (metric_ == Metric::Point ? 3 : 1) * pairs;
  const auto allowed = unknownsOf(objective.motions);
  const auto unknowns = static_cast<double>(std::count(allowed.begin(), allowed.end(), true));
  if (numbers <= unknowns)
    return std::nullopt;
  Spectrum spectrum;
  if (metric_ == Metric::Point) {
    robust *= 0.6745 / 1.5382; // the medians of one normally distributed number and of the length of three
    spectrum = spectrumOf(system);
  }
  else {
    // What the pairs that fit tell: where a normal is wrong, as at an edge, the pair does not. Without a loss, by one
    // for this.
    const Loss fits{LossFunction::Tukey, scaleFrom(residuals, LossFunction::Tukey)};
    const System fitting =
        objective.loss.weighs()
            ? system
            : systemAt(queue, precision, source, pose, pose, matches, target, {fits, objective.motions});
    // The slope of a plane through 20 points is off by their noise over the distance between neighbours: that turns
    // normals, and turned normals tell of motions along the surface. What is no more than twice that is not told.
    // Without noise normals are off where surfaces meet, and residuals of a pose that is off say nothing of normals.
    constexpr double slope = 0.18, least = 0.01, greatest = 0.1, most = 2;
    const double trace = system.unweighedTrace();
    const double noise = trace > 0 ? robust * std::sqrt(pairs / trace) : 0;
    const double of_normals = std::clamp(spacing > 0 ? slope * noise / spacing : 0, least, greatest);
    const double nothing =
        most * most * (of_normals * of_normals + tangential_) + fitting.row_noise * fitting.row_noise;
    spectrum = spectrumAgainst(points.matrixAbout(system.centre), fitting, nothing * fitting.weight() / pairs);
    // Where no motion allowed is across the surface, as of a flat outline within its plane, GICP holds points.
    bool across = isAcross(metric_);
    for (int k = 0; k < 6; ++k)
      across = across || spectrum.isDetermined(k);
    if (!across)
      spectrum = spectrumOf(system);
  }
  const double sigma = sought.loss.weighs() ? robust : std::sqrt(system.cost() / (numbers - unknowns));
  return uncertaintyOf(system, spectrum, sigma);
}

} // namespace pcl_gpu_icp
