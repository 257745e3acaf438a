#pragma once

#include "device_cases.h"
#include "reference.h"

#include <pcl_gpu_icp/rigid_estimator.h>

namespace pcl_gpu_icp::test {

/// A DeviceCase with one of the two pipelines.
struct EstimatorCase {
  DeviceCase device;
  Pipeline pipeline = Pipeline::Fused;

  std::string name() const;
  RigidEstimator estimator() const;
};

std::ostream& operator<<(std::ostream& stream, const EstimatorCase& estimator_case);

/// deviceCases() and kernelCases(), each with both pipelines; of the latter not those that take long: passes on a
/// device that is emulated.
std::vector<EstimatorCase> estimatorCases();
std::vector<EstimatorCase> kernelEstimatorCases();

/// A test with an estimator of its case.
class WithEstimator : public testing::TestWithParam<EstimatorCase> {
protected:
  bool isDouble() const { return GetParam().device.precision == Precision::Double; }
  const DeviceCase& device() const { return GetParam().device; }

  Estimate estimate(const Cloud& source, const Cloud& target)
  {
    return estimator_.estimate(viewOf(source), viewOf(target));
  }

  RigidEstimator estimator_{GetParam().estimator()};
};

/// What holds of every estimate: a proper rotation, and nothing that is not finite.
void expectRigid(const Estimate& estimate, double tolerance);

/// Whether two estimates are the same bits.
bool identical(const Estimate& a, const Estimate& b);

} // namespace pcl_gpu_icp::test

#define RUN_EVERY_ESTIMATOR(Suite)                                                                                     \
  INSTANTIATE_TEST_SUITE_P(, Suite, testing::ValuesIn(estimatorCases()), nameOf<EstimatorCase>)

#define RUN_EVERY_KERNEL_ESTIMATOR(Suite)                                                                              \
  INSTANTIATE_TEST_SUITE_P(, Suite, testing::ValuesIn(kernelEstimatorCases()), nameOf<EstimatorCase>)
