// align() end to end: stock PCL and this library in turn on the same clouds, iteration limit and thread count given,
// trees built and clouds copied in every run. Prints medians and writes JSON.
//   align_benchmark SOURCE.pcd TARGET.pcd [iterations=30] [runs=5] [leaf=0] [drop_zero_returns=0] [json=FILE]
#include <pcl_gpu_icp/icp.h>

#include <pcl/filters/filter.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/io/pcd_io.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <map>

namespace {

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;

struct Options {
  std::string source, target;
  std::map<std::string, std::string> values{
      {"iterations", "30"}, {"runs", "5"}, {"leaf", "0"}, {"drop_zero_returns", "0"}, {"json", ""}};
  double number(const std::string& name) const { return std::stod(values.at(name)); }
};

Options parse(int count, char** arguments)
{
  Options options;
  if (count < 3)
    throw std::invalid_argument("SOURCE.pcd and TARGET.pcd are needed");
  options.source = arguments[1];
  options.target = arguments[2];
  for (int i = 3; i < count; ++i) {
    const std::string argument = arguments[i];
    const auto equals = argument.find('=');
    if (equals == std::string::npos || !options.values.count(argument.substr(0, equals)))
      throw std::invalid_argument("unknown option " + argument);
    options.values[argument.substr(0, equals)] = argument.substr(equals + 1);
  }
  return options;
}

/// Finite points only: stock PCL does not accept others.
Cloud::Ptr load(const std::string& file, const Options& options)
{
  Cloud::Ptr raw(new Cloud), cloud(new Cloud);
  if (pcl::io::loadPCDFile(file, *raw) != 0)
    throw std::runtime_error("cannot read " + file);
  for (const Point& point : *raw)
    if (pcl::isXYZFinite(point) &&
        (options.number("drop_zero_returns") == 0 || point.x != 0 || point.y != 0 || point.z != 0))
      cloud->push_back(point);
  const float leaf = float(options.number("leaf"));
  if (leaf <= 0)
    return cloud;
  Cloud::Ptr reduced(new Cloud);
  pcl::VoxelGrid<Point> grid;
  grid.setLeafSize(leaf, leaf, leaf);
  grid.setInputCloud(cloud);
  grid.filter(*reduced);
  return reduced;
}

template <typename Icp>
double millisecondsOf(Icp& icp, const Cloud::Ptr& source, const Cloud::Ptr& target, int iterations)
{
  // Copies, so that nothing is known from the run before.
  const Cloud::Ptr fresh_source(new Cloud(*source)), fresh_target(new Cloud(*target));
  Cloud output;
  const auto start = std::chrono::steady_clock::now();
  icp.setInputSource(fresh_source);
  icp.setInputTarget(fresh_target);
  icp.setMaximumIterations(iterations);
  icp.align(output);
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values)
{
  std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
  return values[values.size() / 2];
}

template <typename Icp>
nlohmann::json describe(Icp& icp, const std::vector<double>& times)
{
  nlohmann::json rows = nlohmann::json::array();
  for (int i = 0; i < 4; ++i) {
    rows.push_back(nlohmann::json::array());
    for (int j = 0; j < 4; ++j)
      rows.back().push_back(icp.getFinalTransformation()(i, j));
  }
  return {{"median_ms", median(times)}, {"runs_ms", times}, {"fitness", icp.getFitnessScore()}, {"transform", rows}};
}

void run(const Options& options)
{
  const auto source = load(options.source, options), target = load(options.target, options);
  const int iterations = int(options.number("iterations")), runs = int(options.number("runs"));

  // A new process's first alignment: the device and its kernels.
  pcl_gpu_icp::IterativeClosestPoint<Point, Point> starting;
  const Cloud::Ptr few(new Cloud(10, 1, Point(1, 2, 3)));
  millisecondsOf(starting, few, few, 1);
  const double start_ms = starting.getResult().host_times.at("start").milliseconds;

  std::vector<double> stock_ms, ours_ms, ratios;
  nlohmann::json report;
  // Both aligners live on, as they do in a pipeline; the target is a new one each time.
  pcl::IterativeClosestPoint<Point, Point> stock;
  pcl_gpu_icp::IterativeClosestPoint<Point, Point> ours;
  millisecondsOf(ours, few, few, 1);
  for (int i = 0; i < runs; ++i) {
    stock_ms.push_back(millisecondsOf(stock, source, target, iterations));
    ours_ms.push_back(millisecondsOf(ours, source, target, iterations));
    ratios.push_back(stock_ms.back() / ours_ms.back());
    // Else the next run finds the tree of the same coordinates.
    millisecondsOf(ours, few, few, 1);
  }
  report["source"] = options.source;
  report["target"] = options.target;
  report["source_points"] = source->size();
  report["target_points"] = target->size();
  report["iterations"] = iterations;
  report["device"] = ours.getResult().device.name;
  report["threads"] = ours.getNumberOfThreads();
  report["start_ms"] = start_ms;
  millisecondsOf(ours, source, target, iterations);
  report["stock"] = describe(stock, stock_ms);
  report["ours"] = describe(ours, ours_ms);
  report["ratio_of_medians"] = median(stock_ms) / median(ours_ms);
  report["median_of_ratios"] = median(ratios);
  std::cout << options.source << ": " << source->size() << " onto " << target->size() << " points, " << iterations
            << " iterations: stock " << median(stock_ms) << " ms, ours " << median(ours_ms) << " ms, "
            << report["ratio_of_medians"] << "x (device start-up " << start_ms << " ms, once per process)\n";
  if (!options.values.at("json").empty())
    std::ofstream(options.values.at("json")) << report.dump(2) << "\n";
}

} // namespace

int main(int count, char** arguments)
{
  try {
    run(parse(count, arguments));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "align_benchmark: " << error.what() << "\n";
    return 1;
  }
}
