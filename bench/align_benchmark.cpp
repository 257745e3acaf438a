// One method of this library's or of PCL's on one pair of clouds, in a process of its own; bench/compare.py runs it.
//   align_benchmark stock|pcl|device|accelerated|planes|gicp|stock_planes|stock_gicp SOURCE TARGET ITERATIONS
//                   [converge|window|precise [LIMIT]]
//   align_benchmark points SCAN.pcd POINTS     writes the finite points of a scan
// Clouds are raw float32 triples. Prints a line of JSON: milliseconds from clouds to transform (trees included, nothing
// known from before), iterations, transform, the process's peak memory, and what the device took to start.
// `converge`: ends by small_gicp's criteria, `precise`: by a tenth of them. LIMIT: no pair is farther apart.
// `window`: ten sources, each every tenth point of SOURCE from another one on, aligned one after another onto the same
// target; milliseconds are those of all, and of each.
#include <pcl_gpu_icp/gicp.h>
#include <pcl_gpu_icp/icp.h>

#include <pcl/common/io.h>
#include <pcl/features/normal_3d.h>
#include <pcl/io/pcd_io.h>

#include <nlohmann/json.hpp>

#include <chrono>
#include <fstream>
#include <iostream>
#include <numeric>
#include <sys/resource.h>
#include <type_traits>
#include <vector>

namespace {

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;
using Stock = pcl::IterativeClosestPoint<Point, Point>;
using Ours = pcl_gpu_icp::IterativeClosestPoint<Point, Point>;
using StockGeneralized = pcl::GeneralizedIterativeClosestPoint<Point, Point>;
using OursGeneralized = pcl_gpu_icp::GeneralizedIterativeClosestPoint<Point, Point>;

/// Point-to-plane of PCL, the normals by PCL from 20 neighbours.
class StockPlanes : public pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> {
  using Base = pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal>;

  static PointCloudSourcePtr withNormals(const Cloud::Ptr& cloud)
  {
    PointCloudSourcePtr result(new PointCloudSource);
    pcl::copyPointCloud(*cloud, *result);
    pcl::NormalEstimation<Point, pcl::PointNormal> estimation;
    estimation.setInputCloud(cloud);
    estimation.setKSearch(20);
    estimation.compute(*result);
    return result;
  }

public:
  void setInputSource(const Cloud::Ptr& cloud) { Base::setInputSource(withNormals(cloud)); }
  void setInputTarget(const Cloud::Ptr& cloud) { Base::setInputTarget(withNormals(cloud)); }
  void align(Cloud& /*output*/)
  {
    PointCloudSource output;
    Base::align(output);
  }
};

Cloud::Ptr load(const char* path)
{
  std::ifstream file(path, std::ios::binary);
  Cloud::Ptr cloud(new Cloud);
  for (float xyz[3]; file.read(reinterpret_cast<char*>(xyz), sizeof(xyz));)
    cloud->push_back(Point(xyz[0], xyz[1], xyz[2]));
  if (cloud->empty())
    throw std::runtime_error(std::string("cannot read points from ") + path);
  return cloud;
}

void writePoints(const char* scan, const char* path)
{
  Cloud cloud;
  if (pcl::io::loadPCDFile(scan, cloud) != 0)
    throw std::runtime_error(std::string("cannot read ") + scan);
  std::ofstream file(path, std::ios::binary);
  for (const Point& point : cloud)
    if (pcl::isXYZFinite(point))
      file.write(reinterpret_cast<const char*>(point.data), 3 * sizeof(float));
  if (!file.flush())
    throw std::runtime_error(std::string("cannot write ") + path);
}

/// \param target null: the one before
template <typename Icp>
double millisecondsOf(Icp& icp, const Cloud::Ptr& source, const Cloud::Ptr& target)
{
  Cloud output;
  const auto start = std::chrono::steady_clock::now();
  icp.setInputSource(source);
  if (target)
    icp.setInputTarget(target);
  icp.align(output);
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

template <typename Icp>
nlohmann::json window(Icp& icp, const Cloud::Ptr& source, const Cloud::Ptr& target)
{
  constexpr std::size_t sources = 10;
  std::vector<double> each;
  for (std::size_t first = 0; first < sources; ++first) {
    const Cloud::Ptr part(new Cloud);
    for (std::size_t i = first; i < source->size(); i += sources)
      part->push_back((*source)[i]);
    each.push_back(millisecondsOf(icp, part, first == 0 ? target : nullptr));
  }
  return {{"ms", std::accumulate(each.begin(), each.end(), 0.0)}, {"each_ms", each}};
}

template <typename Icp>
nlohmann::json measure(Icp& icp, int count, char** arguments, int warm_ups)
{
  const auto source = load(arguments[2]), target = load(arguments[3]);
  const std::string mode = count > 5 ? arguments[5] : "";
  if (count > 6)
    icp.setMaxCorrespondenceDistance(std::stod(arguments[6]));
  icp.setMaximumIterations(std::stoi(arguments[4]));
  // GICP's default criteria are much the same.
  if ((mode == "converge" || mode == "precise") && !std::is_base_of_v<StockGeneralized, Icp>) {
    // The criteria of small_gicp: an increment of less than 1 mm and 0.1 degrees.
    const double share = mode == "precise" ? 0.1 : 1;
    icp.setTransformationEpsilon(1e-6 * share * share);
    icp.setTransformationRotationEpsilon(std::cos(0.1 * share * M_PI / 180));
  }
  const Cloud::Ptr few(new Cloud(30, 1, Point(1, 2, 3))); // more than GICP has neighbours
  for (int i = 0; i < warm_ups; ++i)
    millisecondsOf(icp, source, target);
  if (warm_ups > 0)
    millisecondsOf(icp, few, few);
  nlohmann::json result;
  if (mode == "window")
    result = window(icp, source, target);
  else
    result["ms"] = millisecondsOf(icp, source, target);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      result["transform"][i][j] = icp.getFinalTransformation()(i, j);
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  result["peak_mib"] = double(usage.ru_maxrss) / 1024;
  return result;
}

template <typename Icp>
nlohmann::json measureOurs(Icp& icp, int count, char** arguments)
{
  nlohmann::json result = measure(icp, count, arguments, 1);
  const auto& last = icp.getResult();
  result["iterations"] = last.iterations;
  result["searched"] = last.searched;
  result["device_bytes"] = last.device_bytes;
  for (const auto& [what, time] : last.host_times)
    result["host_ms"][what] = time.milliseconds;
  result["device"] = last.device.name;
  result["driver"] = last.device.driver;
  return result;
}

nlohmann::json run(int count, char** arguments)
{
  if (count < 5)
    throw std::invalid_argument("align_benchmark stock|pcl|device|accelerated|planes|gicp|stock_planes|stock_gicp "
                                "SOURCE TARGET ITERATIONS [converge|window|precise [LIMIT]]");
  const std::string method = arguments[1];
  if (method == "stock") {
    Stock icp;
    return measure(icp, count, arguments, 0);
  }
  if (method == "stock_planes") {
    StockPlanes icp;
    return measure(icp, count, arguments, 0);
  }
  if (method == "stock_gicp") {
    StockGeneralized icp;
    return measure(icp, count, arguments, 0);
  }
  if (method == "gicp") {
    OursGeneralized icp;
    icp.setCorrespondenceSearch(pcl_gpu_icp::CorrespondenceSearch::DeviceKdTree);
    return measureOurs(icp, count, arguments);
  }
  if (method != "pcl" && method != "device" && method != "accelerated" && method != "planes")
    throw std::invalid_argument("unknown method " + method);
  Ours icp;
  icp.setCorrespondenceSearch(method == "pcl" ? pcl_gpu_icp::CorrespondenceSearch::PclKdTree
                                              : pcl_gpu_icp::CorrespondenceSearch::DeviceKdTree);
  icp.setAndersonAcceleration(method == "accelerated");
  if (method == "planes")
    icp.setMetric(pcl_gpu_icp::Metric::Plane);
  return measureOurs(icp, count, arguments);
}

} // namespace

int main(int count, char** arguments)
{
  try {
    if (count == 4 && arguments[1] == std::string("points"))
      writePoints(arguments[2], arguments[3]);
    else
      std::cout << run(count, arguments).dump() << std::endl;
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "align_benchmark: " << error.what() << "\n";
    return 1;
  }
}
