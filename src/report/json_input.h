#pragma once

#include <nlohmann/json.hpp>

#include <string_view>

namespace pcl_gpu_icp::report {

/// JSON that may come from anywhere: no key of an object twice, nested no deeper than anything that the command reads
/// is, so that recursion over it ends.
/// \throws std::invalid_argument that says what is wrong
nlohmann::json parseJson(std::string_view text);

} // namespace pcl_gpu_icp::report
