#pragma once

#include <map>
#include <string>
#include <string_view>

namespace pcl_gpu_icp::report {

/// The members of a JSON object, each value as a command line would have it: an array of numbers, nested or not, as
/// those numbers. A member that is null is left out.
/// \throws std::invalid_argument that says what is wrong
std::map<std::string, std::string> jsonMembers(std::string_view text);

} // namespace pcl_gpu_icp::report
