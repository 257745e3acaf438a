#pragma once

#include "cli/failure.h"

#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// A Failure (Input) that names the file.
Failure inputFailure(const std::string& path, const std::string& why);

/// A text as a shell takes it for one word.
std::string shellWord(const std::string& text);

/// The content of a regular file, or as much of it from its start.
/// \throws Failure (Input)
std::string readFile(const std::string& path, std::size_t most = std::string::npos);

/// Whether a content is no text: near its start it has a NUL byte.
bool looksBinary(std::string_view content);

} // namespace pcl_gpu_icp::cli
