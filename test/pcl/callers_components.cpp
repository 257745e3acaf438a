#include "callers_components.h"

#include <pcl/registration/correspondence_estimation_backprojection.h>
#include <pcl/registration/correspondence_estimation_normal_shooting.h>
#include <pcl/registration/correspondence_rejection_distance.h>
#include <pcl/registration/correspondence_rejection_median_distance.h>
#include <pcl/registration/correspondence_rejection_one_to_one.h>
#include <pcl/registration/correspondence_rejection_organized_boundary.h>
#include <pcl/registration/correspondence_rejection_sample_consensus.h>
#include <pcl/registration/correspondence_rejection_surface_normal.h>
#include <pcl/registration/correspondence_rejection_trimmed.h>
#include <pcl/registration/correspondence_rejection_var_trimmed.h>
#include <pcl/registration/transformation_estimation_2D.h>
#include <pcl/registration/transformation_estimation_dual_quaternion.h>
#include <pcl/registration/transformation_estimation_lm.h>
#include <pcl/registration/transformation_estimation_point_to_plane.h>
#include <pcl/registration/transformation_estimation_point_to_plane_lls.h>
#include <pcl/registration/transformation_estimation_point_to_plane_lls_weighted.h>
#include <pcl/registration/transformation_estimation_svd.h>
#include <pcl/registration/transformation_estimation_svd_scale.h>
#include <pcl/registration/transformation_estimation_symmetric_point_to_plane_lls.h>

#include <stdexcept>

namespace components {

namespace {

using namespace pcl::registration;

template <typename Component, typename Base>
pcl::shared_ptr<Base> made()
{
  return pcl::make_shared<Component>();
}

} // namespace

const std::vector<std::string> estimators = {"Svd",
                                             "SvdScale",
                                             "Lm",
                                             "DualQuaternion",
                                             "PointToPlane",
                                             "PointToPlaneLls",
                                             "PointToPlaneLlsWeighted",
                                             "SymmetricPointToPlaneLls",
                                             "TwoDimensional"};

const std::vector<std::string> correspondences = {"default", "plain", "normal shooting", "back projection"};

const std::vector<std::string> rejectors = {
    "distance", "one to one", "median", "trimmed", "surface normal", "sample consensus", "var trimmed"};

Estimator::Ptr estimator(const std::string& name)
{
  if (name == "Svd")
    return made<TransformationEstimationSVD<Point, Point, double>, Estimator>();
  if (name == "SvdScale")
    return made<TransformationEstimationSVDScale<Point, Point, double>, Estimator>();
  if (name == "Lm")
    return made<TransformationEstimationLM<Point, Point, double>, Estimator>();
  if (name == "DualQuaternion")
    return made<TransformationEstimationDualQuaternion<Point, Point, double>, Estimator>();
  if (name == "PointToPlane")
    return made<TransformationEstimationPointToPlane<Point, Point, double>, Estimator>();
  if (name == "PointToPlaneLls")
    return made<TransformationEstimationPointToPlaneLLS<Point, Point, double>, Estimator>();
  if (name == "PointToPlaneLlsWeighted")
    return made<TransformationEstimationPointToPlaneLLSWeighted<Point, Point, double>, Estimator>();
  if (name == "SymmetricPointToPlaneLls")
    return made<TransformationEstimationSymmetricPointToPlaneLLS<Point, Point, double>, Estimator>();
  if (name == "TwoDimensional")
    return made<TransformationEstimation2D<Point, Point, double>, Estimator>();
  throw std::invalid_argument(name);
}

Correspondences::Ptr correspondenceEstimation(const std::string& name)
{
  if (name == "default")
    return nullptr;
  if (name == "plain")
    return made<CorrespondenceEstimation<Point, Point, double>, Correspondences>();
  if (name == "normal shooting")
    return made<CorrespondenceEstimationNormalShooting<Point, Point, Point, double>, Correspondences>();
  if (name == "back projection")
    return made<CorrespondenceEstimationBackProjection<Point, Point, Point, double>, Correspondences>();
  throw std::invalid_argument(name);
}

Rejector::Ptr rejector(const std::string& name)
{
  if (name == "distance") {
    const auto made = pcl::make_shared<CorrespondenceRejectorDistance>();
    made->setMaximumDistance(0.01F);
    return made;
  }
  if (name == "one to one")
    return pcl::make_shared<CorrespondenceRejectorOneToOne>();
  if (name == "organized boundary")
    return pcl::make_shared<CorrespondenceRejectionOrganizedBoundary>();
  if (name == "median") {
    const auto made = pcl::make_shared<CorrespondenceRejectorMedianDistance>();
    made->setMedianFactor(1.5);
    return made;
  }
  if (name == "trimmed") {
    const auto made = pcl::make_shared<CorrespondenceRejectorTrimmed>();
    made->setOverlapRatio(0.7F);
    return made;
  }
  if (name == "surface normal") {
    const auto made = pcl::make_shared<CorrespondenceRejectorSurfaceNormal>();
    made->setThreshold(0.7);
    return made;
  }
  if (name == "sample consensus") {
    const auto made = pcl::make_shared<CorrespondenceRejectorSampleConsensus<Point>>();
    made->setInlierThreshold(0.01);
    made->setMaximumIterations(100);
    return made;
  }
  if (name == "var trimmed")
    return pcl::make_shared<CorrespondenceRejectorVarTrimmed>();
  throw std::invalid_argument(name);
}

} // namespace components
