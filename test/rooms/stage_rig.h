#pragma once

#include "device_cases.h"
#include "kernels/layout.h"
#include "opencl/queue.h"
#include "reference.h"
#include "stages/launch.h"
#include "stages/pairs.h"

#include <algorithm>
#include <vector>

namespace pcl_gpu_icp::test {

/// What a single stage needs around it: a queue, the solution record it reads and writes, and pairs. Values are
/// doubles here, whatever the device's `real` is.
class StageRig {
public:
  explicit StageRig(const DeviceCase& device_case)
  : double_(device_case.precision == Precision::Double)
  , queue(device_case.device, device_case.traits, stages::buildOptions(device_case.traits, device_case.precision))
  {
  }

  std::size_t realBytes() const { return double_ ? sizeof(double) : sizeof(float); }

  void writeSolution(const RigidSolution<double>& record)
  {
    if (double_)
      writeSolutionAs<double>(record);
    else
      writeSolutionAs<float>(record);
  }

  RigidSolution<double> readSolution() { return double_ ? readSolutionAs<double>() : readSolutionAs<float>(); }

  void writeReals(opencl::Buffer& buffer, const std::vector<double>& values)
  {
    queue.upload(buffer, values.size() * realBytes(), [&](void* memory) {
      if (double_)
        std::copy(values.begin(), values.end(), static_cast<double*>(memory));
      else
        std::copy(values.begin(), values.end(), static_cast<float*>(memory));
    });
  }

  std::vector<double> readReals(const opencl::Buffer& buffer, std::size_t n)
  {
    std::vector<double> values(n);
    queue.download(buffer, n * realBytes(), [&](const void* memory) {
      if (double_)
        std::copy_n(static_cast<const double*>(memory), n, values.begin());
      else
        std::copy_n(static_cast<const float*>(memory), n, values.begin());
    });
    return values;
  }

  std::vector<float> readFloats(const opencl::Buffer& buffer, std::size_t n)
  {
    std::vector<float> values(n);
    queue.download(buffer, n * sizeof(float), [&](const void* memory) {
      std::copy_n(static_cast<const float*>(memory), n, values.begin());
    });
    return values;
  }

  /// Puts pairs on the device as they are: about the origin.
  void writePairs(const Cloud& source, const Cloud& target)
  {
    const auto n = static_cast<std::size_t>(source.cols());
    pairs.count = static_cast<cl_uint>(n);
    pairs.stride = stages::paddedStride(n);
    queue.upload(pairs.rows, PAIR_ROWS * pairs.stride * sizeof(float), [&](void* memory) {
      auto* rows = static_cast<float*>(memory);
      std::fill_n(rows, PAIR_ROWS * pairs.stride, 0.0F);
      for (int axis = 0; axis < 3; ++axis)
        for (std::size_t i = 0; i < n; ++i) {
          rows[axis * pairs.stride + i] = source(axis, i);
          rows[(3 + axis) * pairs.stride + i] = target(axis, i);
        }
    });
  }

private:
  template <typename real>
  void writeSolutionAs(const RigidSolution<double>& record)
  {
    queue.upload(solution, sizeof(RigidSolution<real>), [&](void* memory) {
      copy(record, *static_cast<RigidSolution<real>*>(memory));
    });
  }

  template <typename real>
  RigidSolution<double> readSolutionAs()
  {
    RigidSolution<double> record{};
    queue.download(solution, sizeof(RigidSolution<real>), [&](const void* memory) {
      copy(*static_cast<const RigidSolution<real>*>(memory), record);
    });
    return record;
  }

  template <typename From, typename To>
  static void copy(const From& from, To& to)
  {
    std::copy(std::begin(from.source_centroid), std::end(from.source_centroid), to.source_centroid);
    std::copy(std::begin(from.target_centroid), std::end(from.target_centroid), to.target_centroid);
    std::copy(std::begin(from.H), std::end(from.H), to.H);
    std::copy(std::begin(from.U), std::end(from.U), to.U);
    std::copy(std::begin(from.S), std::end(from.S), to.S);
    std::copy(std::begin(from.V), std::end(from.V), to.V);
    std::copy(std::begin(from.R), std::end(from.R), to.R);
    std::copy(std::begin(from.t), std::end(from.t), to.t);
    to.rank = from.rank;
  }

  bool double_;

public:
  opencl::Queue queue;
  opencl::Buffer solution{"solution"};
  stages::Pairs pairs;
};

/// A row-major 3x3 matrix of the solution record.
inline Eigen::Matrix3d matrixOf(const double (&row_major)[9])
{
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(row_major);
}

inline Eigen::Vector3d vectorOf(const double (&vector)[3]) { return Eigen::Map<const Eigen::Vector3d>(vector); }

inline void store(const Eigen::Matrix3d& matrix, double (&row_major)[9])
{
  for (int i = 0; i < 9; ++i)
    row_major[i] = matrix(i / 3, i % 3);
}

inline void store(const Eigen::Vector3d& vector, double (&values)[3]) { std::copy_n(vector.data(), 3, values); }

} // namespace pcl_gpu_icp::test
