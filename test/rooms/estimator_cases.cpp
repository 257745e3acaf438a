#include "estimator_cases.h"

#include "engine/estimator_internals.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace pcl_gpu_icp::test {

namespace {

std::vector<EstimatorCase> withBothPipelines(const std::vector<DeviceCase>& devices)
{
  std::vector<EstimatorCase> cases;
  for (const DeviceCase& device : devices)
    for (const Pipeline pipeline : {Pipeline::Staged, Pipeline::Fused})
      cases.push_back({device, pipeline});
  return cases;
}

template <typename Values>
bool sameBits(const Values& a, const Values& b)
{
  return std::memcmp(a.data(), b.data(), sizeof(Values)) == 0;
}

} // namespace

std::string EstimatorCase::name() const
{
  return device.name() + (pipeline == Pipeline::Staged ? "_Staged" : "_Fused");
}

RigidEstimator EstimatorCase::estimator() const
{
  return makeEstimator(device.device, device.traits, pipeline, device.precision);
}

std::ostream& operator<<(std::ostream& stream, const EstimatorCase& estimator_case)
{
  return stream << estimator_case.name() << " on " << estimator_case.device.device.info().name;
}

std::vector<EstimatorCase> estimatorCases() { return withBothPipelines(deviceCases()); }

std::vector<EstimatorCase> kernelEstimatorCases()
{
  std::vector<DeviceCase> devices = kernelCases();
  devices.erase(
      std::remove_if(devices.begin(), devices.end(), [](const auto& d) { return d.isEmulated() && d.inPasses(); }),
      devices.end());
  return withBothPipelines(devices);
}

void expectRigid(const Estimate& estimate, double tolerance)
{
  const Eigen::Matrix3d R = matrixOf(estimate.transform.rotation);
  ASSERT_TRUE(R.allFinite() && vectorOf(estimate.transform.translation).allFinite());
  EXPECT_LE((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_NEAR(R.determinant(), 1, tolerance);
  const StageValues& stages = estimate.stages;
  for (const Eigen::Vector3d& values : {vectorOf(stages.source_pivot),
                                        vectorOf(stages.target_pivot),
                                        vectorOf(stages.source_centroid),
                                        vectorOf(stages.target_centroid),
                                        vectorOf(stages.S),
                                        vectorOf(stages.t)})
    EXPECT_TRUE(values.allFinite());
  for (const Eigen::Matrix3d& values : {matrixOf(stages.H), matrixOf(stages.U), matrixOf(stages.V), matrixOf(stages.R)})
    EXPECT_TRUE(values.allFinite());
}

bool identical(const Estimate& a, const Estimate& b)
{
  return sameBits(a.transform.rotation, b.transform.rotation) &&
         sameBits(a.transform.translation, b.transform.translation) && a.degeneracy == b.degeneracy &&
         a.pairs == b.pairs && sameBits(a.stages.source_pivot, b.stages.source_pivot) &&
         sameBits(a.stages.target_pivot, b.stages.target_pivot) &&
         sameBits(a.stages.source_centroid, b.stages.source_centroid) &&
         sameBits(a.stages.target_centroid, b.stages.target_centroid) && sameBits(a.stages.H, b.stages.H) &&
         sameBits(a.stages.U, b.stages.U) && sameBits(a.stages.S, b.stages.S) && sameBits(a.stages.V, b.stages.V) &&
         sameBits(a.stages.R, b.stages.R) && sameBits(a.stages.t, b.stages.t);
}

} // namespace pcl_gpu_icp::test
