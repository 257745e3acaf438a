#pragma once

#include "harness.h"

#include "cli/manifest.h"

namespace pcl_gpu_icp::fuzz {

inline void readManifest(const std::string& path, std::string_view content)
{
  static cli::PairOptions options; // takes longer to make than to use
  std::vector<cli::ListedPair> pairs;
  if (!reads(path, [&] { pairs = cli::parseManifest(path, content, {{"leaf", "0.5"}}, options); }))
    return;
  require(!pairs.empty(), "a manifest that was read has pairs");
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    require(pairs[i].identity.pair == i, "pairs are numbered as they are listed");
    for (const std::string* name : {&pairs[i].alignment.source, &pairs[i].alignment.target})
      require(!name->empty() && name->find('\0') == std::string::npos, "a pair has names of files");
    require(pairs[i].identity.options.count("leaf") == 1, "a pair has the defaults");
  }
}

} // namespace pcl_gpu_icp::fuzz
