#pragma once

#include "report/json.h"
#include "view/page_data.h"

#include <pcl_gpu_icp/device.h>

#include <string>
#include <vector>

namespace pcl_gpu_icp::view {

/// What repeats a run.
struct Repetition {
  std::string command;   ///< for a shell
  std::string directory; ///< where it ran
  std::string versions;  ///< of what it ran
};

/// The same for a page.
/// \param settings what there is to be known beside the command line
report::Json
repeatJson(const Repetition& repetition, const std::vector<DeviceInfo>& devices, const report::Json& settings);

/// The scripts, one after the other, that showPair() takes.
std::vector<std::string> pairScripts();

/// A page of HTML that needs nothing else. Its parts are named as the files in page/ and those embedded with them.
/// \param run what the scripts know as `run`
std::string pageOf(const std::vector<std::string>& templates,
                   const PageData& data,
                   const report::Json& run,
                   const std::vector<std::string>& scripts);

} // namespace pcl_gpu_icp::view
