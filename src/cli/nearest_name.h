#pragma once

#include <string>
#include <vector>

namespace pcl_gpu_icp::cli {

/// What follows an error that this name would not have made: "; did you mean NAME?"
std::string proposal(const std::string& name);

/// What follows an error about a name that is none of `names`: proposal() of the nearest, or nothing where none is
/// near. Near is up to a third of the letters wrong, missing, too many or in each other's place.
std::string didYouMean(const std::string& mistyped, const std::vector<std::string>& names);

} // namespace pcl_gpu_icp::cli
