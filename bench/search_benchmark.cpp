// A search from anywhere on the pairs that standard input names, a line each: SOURCE TARGET, raw float32 triples.
// Answers each with a line of JSON: milliseconds from clouds to pose, and the pose. bench/anywhere.py runs it beside
// its peers.
//   search_benchmark               PoseSearch, with the number of starts that it took
//   search_benchmark pcl VOXEL     pcl::SampleConsensusPrerejective over FPFH; the clouds are thinned to such voxels
#include <pcl_gpu_icp/pose_search.h>

#include <pcl/features/fpfh.h>
#include <pcl/features/normal_3d.h>
#include <pcl/registration/sample_consensus_prerejective.h>

#include <nlohmann/json.hpp>

#include <array>
#include <chrono>
#include <fstream>
#include <functional>
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

/// Fills in what was found.
using Search = std::function<void(const Cloud& source, const Cloud& target, nlohmann::json& answer)>;

Search poseSearch()
{
  return [search = pcl_gpu_icp::PoseSearch(pcl_gpu_icp::Device::select())](
             const Cloud& source, const Cloud& target, nlohmann::json& answer) {
    const auto found = search.search(viewOf(source), viewOf(target));
    answer["starts"] = found.starts;
    if (found.poses.empty())
      return;
    const pcl_gpu_icp::RigidTransform& pose = found.poses[0].transform;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        answer["transform"][row][column] = pose.rotation[3 * row + column];
      answer["transform"][row][3] = pose.translation[row];
    }
    answer["transform"][3] = {0, 0, 0, 1};
  };
}

struct WithFeatures {
  pcl::PointCloud<pcl::PointNormal>::Ptr points{new pcl::PointCloud<pcl::PointNormal>};
  pcl::PointCloud<pcl::FPFHSignature33>::Ptr features{new pcl::PointCloud<pcl::FPFHSignature33>};

  WithFeatures(const Cloud& cloud, double voxel)
  {
    for (const auto& [x, y, z] : cloud) {
      pcl::PointNormal point;
      point.x = x, point.y = y, point.z = z;
      points->push_back(point);
    }
    pcl::NormalEstimation<pcl::PointNormal, pcl::PointNormal> normals;
    normals.setRadiusSearch(2 * voxel);
    normals.setInputCloud(points);
    normals.compute(*points);
    pcl::FPFHEstimation<pcl::PointNormal, pcl::PointNormal, pcl::FPFHSignature33> estimation;
    estimation.setRadiusSearch(5 * voxel);
    estimation.setInputCloud(points);
    estimation.setInputNormals(points);
    estimation.compute(*features);
  }
};

/// With the settings of PCL's tutorial on it.
Search prerejective(double voxel)
{
  return [voxel](const Cloud& source, const Cloud& target, nlohmann::json& answer) {
    const WithFeatures of_source(source, voxel), of_target(target, voxel);
    pcl::SampleConsensusPrerejective<pcl::PointNormal, pcl::PointNormal, pcl::FPFHSignature33> search;
    search.setInputSource(of_source.points);
    search.setSourceFeatures(of_source.features);
    search.setInputTarget(of_target.points);
    search.setTargetFeatures(of_target.features);
    search.setMaximumIterations(50000);
    search.setNumberOfSamples(3);
    search.setCorrespondenceRandomness(5);
    search.setSimilarityThreshold(0.9F);
    search.setMaxCorrespondenceDistance(2.5 * voxel);
    search.setInlierFraction(0.25F);
    pcl::PointCloud<pcl::PointNormal> output;
    search.align(output);
    if (!search.hasConverged())
      return;
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column)
        answer["transform"][row][column] = search.getFinalTransformation()(row, column);
  };
}

void run(const Search& search)
{
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream names(line);
    std::string source_name, target_name;
    names >> source_name >> target_name;
    const Cloud source = load(source_name), target = load(target_name);
    nlohmann::json answer;
    const auto start = std::chrono::steady_clock::now();
    search(source, target, answer);
    answer["ms"] = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    std::cout << answer.dump() << std::endl;
  }
}

} // namespace

int main(int count, char** arguments)
{
  try {
    run(count == 3 && arguments[1] == std::string("pcl") ? prerejective(std::stod(arguments[2])) : poseSearch());
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "search_benchmark: " << error.what() << "\n";
    return 1;
  }
}
