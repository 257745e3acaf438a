#pragma once

#include "view/page.h"

namespace pcl_gpu_icp::cli {

/// What started this process, as a shell takes it, also where arguments are no UTF-8 or have line feeds in them.
view::Repetition thisRun();

} // namespace pcl_gpu_icp::cli
