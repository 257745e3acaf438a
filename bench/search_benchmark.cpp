// PoseSearch on the pairs that standard input names, a line each: SOURCE TARGET, raw float32 triples. Answers each with
// a line of JSON: milliseconds from clouds to pose, and the pose. bench/anywhere.py runs it beside its peers.
#include <pcl_gpu_icp/pose_search.h>

#include <nlohmann/json.hpp>

#include <array>
#include <chrono>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using Cloud = std::vector<std::array<float, 3>>;

Cloud load(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  Cloud cloud;
  for (std::array<float, 3> xyz; file.read(reinterpret_cast<char*>(xyz.data()), sizeof(xyz));)
    cloud.push_back(xyz);
  if (cloud.empty())
    throw std::runtime_error("cannot read points from " + path);
  return cloud;
}

pcl_gpu_icp::Points viewOf(const Cloud& cloud) { return {cloud.data(), cloud.size(), sizeof(cloud[0])}; }

void run()
{
  const pcl_gpu_icp::PoseSearch search{pcl_gpu_icp::Device::select()};
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream names(line);
    std::string source_name, target_name;
    names >> source_name >> target_name;
    const Cloud source = load(source_name), target = load(target_name);
    const auto start = std::chrono::steady_clock::now();
    const auto found = search.search(viewOf(source), viewOf(target));
    nlohmann::json answer;
    answer["ms"] = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    if (!found.poses.empty()) {
      const pcl_gpu_icp::RigidTransform& pose = found.poses[0].transform;
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
          answer["transform"][row][column] = pose.rotation[3 * row + column];
        answer["transform"][row][3] = pose.translation[row];
      }
      answer["transform"][3] = {0, 0, 0, 1};
    }
    std::cout << answer.dump() << std::endl;
  }
}

} // namespace

int main()
{
  try {
    run();
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "search_benchmark: " << error.what() << "\n";
    return 1;
  }
}
