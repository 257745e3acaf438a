#pragma once

#include "cli/listed_pair.h"

#include <string>
#include <string_view>
#include <vector>

namespace pcl_gpu_icp::cli {

/// The pairs of a manifest, .csv or .jsonl, whose file names are relative to its folder.
/// \param defaults options of the lines that do not have them
/// \throws Failure (Input) that names the file, the line and the column
std::vector<ListedPair> readManifest(const std::string& path, const OptionTexts& defaults);

/// The same of a manifest's content.
/// \param options what reads the options of its lines
std::vector<ListedPair>
parseManifest(const std::string& path, std::string_view content, const OptionTexts& defaults, PairOptions& options);

} // namespace pcl_gpu_icp::cli
