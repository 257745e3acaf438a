#pragma once

#include <pcl/point_types.h>
#include <pcl/registration/correspondence_estimation.h>
#include <pcl/registration/correspondence_rejection.h>
#include <pcl/registration/transformation_estimation.h>

#include <string>
#include <vector>

// What a caller may put into ICP, by name. In a file of their own: PCL's templates take long to compile.
namespace components {

using Point = pcl::PointNormal;
using Estimator = pcl::registration::TransformationEstimation<Point, Point, double>;
using Correspondences = pcl::registration::CorrespondenceEstimationBase<Point, Point, double>;
using Rejector = pcl::registration::CorrespondenceRejector;

extern const std::vector<std::string> estimators, correspondences, rejectors;

Estimator::Ptr estimator(const std::string& name);

/// null: PCL's own, which "default" stands for.
Correspondences::Ptr correspondenceEstimation(const std::string& name);

Rejector::Ptr rejector(const std::string& name);

} // namespace components
