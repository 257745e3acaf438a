#pragma once

#include <pcl_gpu_icp/device_icp.h>

#include <pcl/pcl_config.h>
#include <pcl/registration/gicp.h>

#include <type_traits>

namespace pcl_gpu_icp {

namespace detail {

#if PCL_VERSION_COMPARE(>=, 1, 13, 0)
template <typename PointSource, typename PointTarget, typename Scalar>
using PclGeneralizedIcp = pcl::GeneralizedIterativeClosestPoint<PointSource, PointTarget, Scalar>;
#else // It knows float alone.
template <typename PointSource, typename PointTarget, typename Scalar>
using PclGeneralizedIcp =
    std::enable_if_t<std::is_same_v<Scalar, float>, pcl::GeneralizedIterativeClosestPoint<PointSource, PointTarget>>;
#endif

} // namespace detail

/// pcl::GeneralizedIterativeClosestPoint (Segal, Haehnel and Thrun 2009) on an OpenCL device. Change the namespace and
/// nothing else: the neighbours that covariances come from (setCorrespondenceRandomness), covariances of the caller's,
/// both epsilons, the limit of the distance and of the iterations, guess, indices and the visualiser callback keep
/// PCL's meaning and defaults. In addition it has the settings of pcl_gpu_icp::IterativeClosestPoint, honours
/// rejectors and reciprocal correspondences, and getResult() tells what it did.
///
/// Where it differs from PCL's class:
/// - for each set of correspondences the cost is brought to its minimum (Gauss-Newton on the device's sums), where
///   BFGS stops at gradient tolerances: setMaximumOptimizerIterations(), setTranslationGradientTolerance() and
///   setRotationGradientTolerance() have nothing to limit;
/// - covariances come from 3 to 32 neighbours; those that are given are held in float32, so that the least of a
///   covariance should be no less than 1e-5 of its greatest;
/// - points that coincide count once as neighbours, and points without a surface about them (on a line, too few) have a
///   covariance of the same size in every direction;
/// - covariances of the caller's are one for each point of the cloud, also where setIndices() leaves some out;
/// - a search method, a correspondence or a transformation estimation of the caller's ends align() with an error;
/// - mahalanobis() is empty.
///
/// As in PCL's class, setEuclideanFitnessEpsilon(), setTransformationRotationEpsilon() and what getConvergeCriteria()
/// has beyond the two epsilons have no effect. The default limit of 5 and epsilon of 5e-4 are in the clouds' unit.
///
/// With PCL 1.12 Scalar can be float only.
///
/// Errors: as in pcl_gpu_icp::IterativeClosestPoint.
template <typename PointSource, typename PointTarget, typename Scalar = float>
class GeneralizedIterativeClosestPoint : public DeviceIcp<detail::PclGeneralizedIcp<PointSource, PointTarget, Scalar>> {
  using Base = DeviceIcp<detail::PclGeneralizedIcp<PointSource, PointTarget, Scalar>>;

public:
  using Ptr = pcl::shared_ptr<GeneralizedIterativeClosestPoint>;
  using ConstPtr = pcl::shared_ptr<const GeneralizedIterativeClosestPoint>;
  using typename Base::Matrix4;

  GeneralizedIterativeClosestPoint();

protected:
  typename Base::CovarianceSettings covarianceSettings() const override;
  float squaredLimit() const override;

private:
  /// PCL's GICP goes on until no entry of the rotation has changed by more than the rotation epsilon, and none of the
  /// translation by more than the transformation epsilon.
  class Criteria : public ConvergenceCriteria<Scalar> {
  public:
    explicit Criteria(const GeneralizedIterativeClosestPoint& icp);
    void startAfresh(double spacing) override;
    bool hasConverged() override;

  private:
    Eigen::Matrix4d motion() const;

    const GeneralizedIterativeClosestPoint& icp_;
    Eigen::Matrix4d guess_inverse_, last_motion_;
  };
};

} // namespace pcl_gpu_icp

#include <pcl_gpu_icp/impl/gicp.hpp>
