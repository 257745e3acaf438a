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

/// How an argument names standard input, where that can be read.
constexpr std::string_view standard_input = "-";

/// What a filter does with a file, as a shell takes it.
std::string filtered(const std::string& filter, const std::string& path);

/// All of standard input.
/// \throws Failure (Input)
std::string readStandardInput();

/// Whether a content is no text: near its start it has a NUL byte.
bool looksBinary(std::string_view content);

} // namespace pcl_gpu_icp::cli
