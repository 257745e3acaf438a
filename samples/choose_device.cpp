// Lists the OpenCL devices, aligns on one of them and reads back what was done there.
//   choose_device [SELECTOR]      "gpu", "cpu", "0:1" or part of a device's name
#include "cloud_pair.h"

#include <pcl_gpu_icp/error.h>
#include <pcl_gpu_icp/icp.h>

#include <iostream>

int main(int argc, char** argv)
try {
  for (const pcl_gpu_icp::Device& device : pcl_gpu_icp::Device::list()) {
    const pcl_gpu_icp::DeviceInfo& info = device.info();
    std::cout << info.platform_index << ':' << info.device_index << ' ' << info.name << " (" << toString(info.type)
              << ", " << info.platform << ")\n";
  }

  const CloudPair pair = cloudPair(1, argv);
  pcl_gpu_icp::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
  icp.setDevice(pcl_gpu_icp::Device::select(argc > 1 ? argv[1] : ""));
  icp.setPipeline(pcl_gpu_icp::Pipeline::Staged);
  icp.setInputSource(pair.source);
  icp.setInputTarget(pair.target);
  icp.setMaximumIterations(50);
  icp.setTransformationEpsilon(1e-10);
  Cloud aligned;
  icp.align(aligned);

  const pcl_gpu_icp::AlignmentResult& result = icp.getResult();
  std::cout << toString(result.reason) << " after " << result.iterations << " iterations on " << result.device.name
            << ", " << toString(result.pipeline) << ", rmse " << result.rmse_before << " -> " << result.rmse << '\n';
  for (const auto& [stage, time] : result.device_times)
    std::cout << "  " << stage << ": " << time.milliseconds << " ms in " << time.count << " commands\n";
  return result.converged ? 0 : 1;
} catch (const pcl_gpu_icp::DeviceError& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
