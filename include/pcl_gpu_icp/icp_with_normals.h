#pragma once

#include <pcl_gpu_icp/device_icp.h>

#include <pcl/registration/icp.h>

#include <typeinfo>

namespace pcl_gpu_icp {

/// pcl::IterativeClosestPointWithNormals on an OpenCL device: Metric::Plane, with the target's normals; with
/// setUseSymmetricObjective(true) Metric::Symmetric, with both clouds'. Where in addition
/// setEnforceSameDirectionNormals(false) is asked for, PCL's own estimator makes the increments, on the host.
/// Normals that nobody computed, all zero or not finite, are an error (Reason::Error). setMetric() makes it one of the
/// others. Everything else as in pcl_gpu_icp::IterativeClosestPoint.
template <typename PointSource, typename PointTarget, typename Scalar = float>
class IterativeClosestPointWithNormals
: public DeviceIcp<pcl::IterativeClosestPointWithNormals<PointSource, PointTarget, Scalar>> {
  using Base = DeviceIcp<pcl::IterativeClosestPointWithNormals<PointSource, PointTarget, Scalar>>;

public:
  using Ptr = pcl::shared_ptr<IterativeClosestPointWithNormals>;
  using ConstPtr = pcl::shared_ptr<const IterativeClosestPointWithNormals>;
  using typename Base::Matrix4;
  using typename Base::PointCloudSource;

  IterativeClosestPointWithNormals() { this->setMetric(Metric::Plane); }

protected:
  void computeTransformation(PointCloudSource& output, const Matrix4& guess) override
  {
    // setUseSymmetricObjective() installs PCL's.
    using PclPlanes = pcl::registration::TransformationEstimationPointToPlaneLLS<PointSource, PointTarget, Scalar>;
    using PclSymmetric =
        pcl::registration::TransformationEstimationSymmetricPointToPlaneLLS<PointSource, PointTarget, Scalar>;
    const auto& estimation = *this->transformation_estimation_;
    if (!this->estimatesOnDevice() && typeid(estimation) == typeid(PclPlanes))
      this->setMetric(Metric::Plane);
    else if (this->getMetric() == Metric::Symmetric && !this->getEnforceSameDirectionNormals()) {
      this->setMetric(Metric::Point); // what an estimator of the caller's counts as
      this->setUseSymmetricObjective(true);
    }
    else if (typeid(estimation) == typeid(PclSymmetric) && this->getEnforceSameDirectionNormals())
      this->setMetric(Metric::Symmetric);
    Base::computeTransformation(output, guess);
  }
};

} // namespace pcl_gpu_icp
