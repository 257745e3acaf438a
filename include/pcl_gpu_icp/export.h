#pragma once

/// Marks what the shared library exports; everything else stays inside it.
#define PCL_GPU_ICP_API __attribute__((visibility("default")))
