#pragma once

#include <pcl_gpu_icp/device_icp.h>

#include <pcl/registration/icp.h>

namespace pcl_gpu_icp {

/// pcl::IterativeClosestPoint whose rigid estimation runs on an OpenCL device and whose KD-tree is built once per
/// target and queried from several host threads. Change the namespace and nothing else: guess, indices, rejectors,
/// reciprocal correspondences, custom estimators, search methods and point representations, convergence criteria, the
/// visualiser callback and getFitnessScore() keep PCL's meaning.
///
/// A pcl_gpu_icp::TransformationEstimationPointToPlaneLLS given to setTransformationEstimation() makes it
/// point-to-plane on the device.
///
/// Where it differs from pcl::IterativeClosestPoint 1.12-1.15, it is to keep PCL's documented behaviour:
/// - non-finite points, and those beyond largest_coordinate, never take part, whatever is_dense says;
/// - setIndices() is honoured: only those source points are matched, and the output holds just them;
/// - the source is transformed from the original by the accumulated transform, so rounding does not drift; an estimator
///   of the caller's is handed, to the bit, the cloud and the correspondences that PCL would hand it;
/// - the convergence criteria start afresh in every align();
/// - an align() that cannot start leaves hasConverged() false and the final transformation at the identity;
/// - the default threshold of the mean squared distance, 1e-12 in PCL whatever the unit, is (1e-5 s)^2, where s is the
///   target's surfaceSpacing(); setAbsoluteMSE() sets it as in PCL;
/// - a guess that is not isRigid() is an error, unless the caller's own estimator, which may scale, makes the
/// increments.
/// - setInputSource() and setInputTarget() with a null pointer or an empty cloud forget the one before.
///
/// Errors: what ends an alignment is reported through PCL_ERROR; hasConverged() is false, the final transformation is
/// the guess, and getResult() has the cause. align() does not throw.
template <typename PointSource, typename PointTarget, typename Scalar = float>
class IterativeClosestPoint : public DeviceIcp<pcl::IterativeClosestPoint<PointSource, PointTarget, Scalar>> {
public:
  using Ptr = pcl::shared_ptr<IterativeClosestPoint>;
  using ConstPtr = pcl::shared_ptr<const IterativeClosestPoint>;
};

} // namespace pcl_gpu_icp
