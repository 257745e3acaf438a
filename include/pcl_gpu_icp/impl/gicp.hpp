#pragma once

#include <pcl_gpu_icp/gicp.h>

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp {

namespace detail {

/// What PCL's GICP is given for each point; none where it is given nothing.
template <typename Matrices>
PointCovariances pointCovariances(const Matrices* matrices)
{
  PointCovariances covariances;
  if (matrices)
    for (const Eigen::Matrix3d& matrix : *matrices)
      covariances.push_back({static_cast<float>(matrix(0, 0)),
                             static_cast<float>(matrix(0, 1)),
                             static_cast<float>(matrix(0, 2)),
                             static_cast<float>(matrix(1, 1)),
                             static_cast<float>(matrix(1, 2)),
                             static_cast<float>(matrix(2, 2))});
  return covariances;
}

} // namespace detail

template <typename PointSource, typename PointTarget, typename Scalar>
GeneralizedIterativeClosestPoint<PointSource, PointTarget, Scalar>::GeneralizedIterativeClosestPoint()
{
  this->setMetric(Metric::Generalized);
  this->convergence_criteria_.reset(new Criteria(*this));
}

template <typename PointSource, typename PointTarget, typename Scalar>
typename GeneralizedIterativeClosestPoint<PointSource, PointTarget, Scalar>::Base::CovarianceSettings
GeneralizedIterativeClosestPoint<PointSource, PointTarget, Scalar>::covarianceSettings() const
{
  typename Base::CovarianceSettings settings;
  settings.neighbours = static_cast<unsigned>(std::max(this->k_correspondences_, 0));
  settings.epsilon = this->gicp_epsilon_;
  settings.of_source = detail::pointCovariances(this->input_covariances_.get());
  settings.of_target = detail::pointCovariances(this->target_covariances_.get());
  return settings;
}

/// Pairs at the limit itself are none in PCL's GICP.
template <typename PointSource, typename PointTarget, typename Scalar>
float GeneralizedIterativeClosestPoint<PointSource, PointTarget, Scalar>::squaredLimit() const
{
  const float at_most = Base::squaredLimit();
  const bool is_held = std::isfinite(at_most) && at_most == this->corr_dist_threshold_ * this->corr_dist_threshold_;
  return is_held ? std::nextafter(at_most, 0.0F) : at_most;
}

template <typename PointSource, typename PointTarget, typename Scalar>
GeneralizedIterativeClosestPoint<PointSource, PointTarget, Scalar>::Criteria::Criteria(
    const GeneralizedIterativeClosestPoint& icp)
: ConvergenceCriteria<Scalar>(icp.nr_iterations_, icp.transformation_, *icp.correspondences_)
, icp_(icp)
{
}

template <typename PointSource, typename PointTarget, typename Scalar>
Eigen::Matrix4d GeneralizedIterativeClosestPoint<PointSource, PointTarget, Scalar>::Criteria::motion() const
{
  return icp_.final_transformation_.template cast<double>() * guess_inverse_;
}

template <typename PointSource, typename PointTarget, typename Scalar>
void GeneralizedIterativeClosestPoint<PointSource, PointTarget, Scalar>::Criteria::startAfresh(double spacing)
{
  ConvergenceCriteria<Scalar>::startAfresh(spacing);
  guess_inverse_ = icp_.final_transformation_.template cast<double>().inverse();
  last_motion_.setIdentity();
}

template <typename PointSource, typename PointTarget, typename Scalar>
bool GeneralizedIterativeClosestPoint<PointSource, PointTarget, Scalar>::Criteria::hasConverged()
{
  const Eigen::Matrix4d change = (motion() - last_motion_).cwiseAbs();
  last_motion_ = motion();
  const bool turned = change.template topLeftCorner<3, 3>().maxCoeff() >= icp_.rotation_epsilon_;
  const bool shifted = change.template topRightCorner<3, 1>().maxCoeff() >= icp_.transformation_epsilon_;
  const bool ends = this->iterations_ >= this->max_iterations_;
  this->setConvergenceState(!turned && !shifted ? Criteria::CONVERGENCE_CRITERIA_TRANSFORM
                            : ends              ? Criteria::CONVERGENCE_CRITERIA_ITERATIONS
                                                : Criteria::CONVERGENCE_CRITERIA_NOT_CONVERGED);
  return ends || (!turned && !shifted);
}

} // namespace pcl_gpu_icp
