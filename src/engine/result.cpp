#include <pcl_gpu_icp/result.h>

#include "stages/centroid.h"
#include "stages/cross_covariance.h"
#include "stages/demean.h"
#include "stages/rigid_transform.h"
#include "stages/svd.h"

namespace pcl_gpu_icp {

const char* toString(Pipeline pipeline) { return pipeline == Pipeline::Staged ? "staged" : "fused"; }

const char* toString(CorrespondenceSearch search)
{
  switch (search) {
  case CorrespondenceSearch::PclKdTree:
    return "pcl";
  case CorrespondenceSearch::DeviceKdTree:
    return "device";
  }
  return "unknown";
}

const char* toString(Precision precision) { return precision == Precision::Double ? "double" : "float"; }

const char* toString(Metric metric)
{
  switch (metric) {
  case Metric::Plane:
    return "plane";
  case Metric::Symmetric:
    return "symmetric";
  case Metric::Generalized:
    return "gicp";
  default:
    return "point";
  }
}

const char* toString(Degeneracy degeneracy)
{
  switch (degeneracy) {
  case Degeneracy::None:
    return "none";
  case Degeneracy::Sliding:
    return "sliding";
  case Degeneracy::Line:
    return "line";
  case Degeneracy::Point:
    return "point";
  case Degeneracy::Empty:
    return "empty";
  }
  return "unknown";
}

const char* toString(Reason reason)
{
  switch (reason) {
  case Reason::NotRun:
    return "not run";
  case Reason::Iterations:
    return "iterations";
  case Reason::Transform:
    return "transform";
  case Reason::AbsoluteMse:
    return "absolute mse";
  case Reason::RelativeMse:
    return "relative mse";
  case Reason::NoCorrespondences:
    return "no correspondences";
  case Reason::FailureAfterIterations:
    return "failure after iterations";
  case Reason::Cancelled:
    return "cancelled";
  case Reason::Error:
    return "error";
  }
  return "unknown";
}

std::vector<StageRequest> stageRequests(std::size_t pairs)
{
  return {stages::Centroid::request(pairs),
          stages::Demean::request(pairs),
          stages::CrossCovariance::request(pairs),
          stages::Svd::request(),
          stages::RotationTranslation::request()};
}

} // namespace pcl_gpu_icp
