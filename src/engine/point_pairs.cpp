#include "point_pairs.h"

#include "uncertainty_internals.h"
#include "values_at.h"

#include <pcl_gpu_icp/matcher.h>

#include <cmath>
#include <limits>

namespace pcl_gpu_icp {

void PointPairs::add(const std::array<double, 3>& p, double squared_distance)
{
  const std::array<double, 3> x{p[0] - origin_[0], p[1] - origin_[1], p[2] - origin_[2]};
  for (int i = 0; i < 3; ++i) {
    sum_[i] += each_ * x[i];
    for (int j = 0; j < 3; ++j)
      products_[i][j] += each_ * x[i] * x[j];
  }
  squared_distances_ += each_ * squared_distance;
  count_ += each_;
}

SquareMatrix<6> PointPairs::matrixAbout(const std::array<double, 3>& centre) const
{
  const double n = count_;
  std::array<double, 3> sum{};
  SquareMatrix<3> products{};
  for (int i = 0; i < 3; ++i)
    sum[i] = sum_[i] - n * (centre[i] - origin_[i]);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      products[i][j] = products_[i][j] - (sum_[i] * sum_[j] - sum[i] * sum[j]) / n;
  const double trace = products[0][0] + products[1][1] + products[2][2];
  SquareMatrix<6> matrix{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      matrix[i][j] = (i == j ? trace : 0) - products[i][j];
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    matrix[i][3 + k] = matrix[3 + k][i] = sum[j];
    matrix[i][3 + j] = matrix[3 + j][i] = -sum[k];
    matrix[3 + i][3 + i] = n;
  }
  return matrix;
}

std::optional<Uncertainty> PointPairs::uncertainty(double rounding) const
{
  constexpr double unknowns = 6, of_a_pair = 3;
  const double n = count_;
  if (of_a_pair * n <= unknowns)
    return std::nullopt;
  System system;
  for (int i = 0; i < 3; ++i)
    system.centre[i] = origin_[i] + sum_[i] / n;
  const SquareMatrix<6> matrix = matrixAbout(system.centre);
  setMatrix(system, matrix);
  const double squared_radius = (matrix[0][0] + matrix[1][1] + matrix[2][2]) / (2 * n);
  const double length = std::sqrt(std::max(squared_radius, 0.0));
  system.length = length > rounding ? length : 1;
  system.row_noise = rounding / system.length;
  system.sum_noise = 8 * std::numeric_limits<double>::epsilon();
  const double sigma = std::sqrt(squared_distances_ / (of_a_pair * n - unknowns));
  return uncertaintyOf(system, spectrumOf(system), sigma);
}

std::optional<Uncertainty> pointUncertainty(const std::vector<Correspondence>& correspondences,
                                            const Points& source,
                                            const Points& target,
                                            const RigidTransform& pose)
{
  if (correspondences.empty())
    return std::nullopt;
  const auto moved = [&](const Correspondence& c) {
    const float* p = valuesAt(source, c.source);
    return pose(p[0], p[1], p[2]);
  };
  const Sample sample(correspondences.size());
  PointPairs pairs(moved(correspondences.front()), sample.each());
  double largest = 0;
  sample.forEach([&](std::size_t i) {
    const Correspondence& c = correspondences[i];
    const auto p = moved(c);
    const float* q = valuesAt(target, c.target);
    double squared_distance = 0;
    for (int axis = 0; axis < 3; ++axis) {
      squared_distance += (p[axis] - q[axis]) * (p[axis] - q[axis]);
      largest = std::max({largest, std::abs(p[axis]), std::abs(static_cast<double>(q[axis]))});
    }
    pairs.add(p, squared_distance);
  });
  return pairs.uncertainty(largest * std::numeric_limits<float>::epsilon() / 2);
}

} // namespace pcl_gpu_icp
