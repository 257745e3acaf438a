#pragma once

#include <pcl/registration/default_convergence_criteria.h>

#include <unordered_set>

namespace pcl_gpu_icp {

/// PCL's criteria, told the mean squared distance instead of adding it up from a list of correspondences, without the
/// last alignment's, and with a default for the absolute threshold that follows from the spacing. The step from one
/// pose to the next is a function of the pose as float32 holds it, so a mean squared distance that was there before,
/// to the bit, comes again and again: that counts as no change, where no more than last digits change on the way.
template <typename Scalar>
class ConvergenceCriteria : public pcl::registration::DefaultConvergenceCriteria<Scalar> {
public:
  using Matrix4 = Eigen::Matrix<Scalar, 4, 4>;

  ConvergenceCriteria(const int& iterations, const Matrix4& increment, const pcl::Correspondences& correspondences);
  virtual void startAfresh(double spacing);
  void setMeanSquaredDistance(double value) { mean_squared_distance_ = value; }
  bool hasConverged() override;

private:
  double mean_squared_distance_ = 0;
  double threshold_ = 0;               ///< the absolute one of this alignment
  std::unordered_set<double> earlier_; ///< mean squared distances of this alignment
};

} // namespace pcl_gpu_icp

#include <pcl_gpu_icp/impl/convergence_criteria.hpp>
