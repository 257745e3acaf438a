// Prints the device that the environment selects, or why there is none.
#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/error.h>

#include <iostream>

int main()
{
  try {
    std::cout << pcl_gpu_icp::Device::select().info().name << "\n";
    return 0;
  } catch (const pcl_gpu_icp::DeviceError& error) {
    std::cout << error.what() << "\n";
    return 4;
  }
}
