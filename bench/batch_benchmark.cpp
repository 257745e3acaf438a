// Many cloud pairs cut from real scans, by one method, in a process of its own; bench/batch.py runs it. Prints a line
// of JSON: milliseconds from clouds to transforms for all pairs, when each was finished, how busy the device was, and
// (for tiny pairs) how memory and open files grew.
#include <pcl_gpu_icp/batch.h>

#include <pcl/io/pcd_io.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <random>
#include <unistd.h>
#include <vector>

namespace {

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;
using Stock = pcl::IterativeClosestPoint<Point, Point>;
using Ours = pcl_gpu_icp::IterativeClosestPoint<Point, Point>;
using Clock = std::chrono::steady_clock;

struct Pair {
  Cloud::Ptr source, target;
};

struct Options {
  std::string scans, workload, method;
  std::string policy = "smallest";
  std::string search = "device";
  std::size_t capacity = 0;
  unsigned lanes = 0;
  std::size_t pairs = 64;
  std::size_t first = 0, step = 1; ///< of the pairs only first, first + step, ...
  int iterations = 30;
};

/// The measurements of a scan: finite, and no zero returns.
Cloud::Ptr load(const std::string& path)
{
  Cloud raw;
  if (pcl::io::loadPCDFile(path, raw) != 0)
    throw std::runtime_error("cannot read " + path);
  const Cloud::Ptr cloud(new Cloud);
  for (const Point& point : raw)
    if (pcl::isXYZFinite(point) && point.getVector3fMap().squaredNorm() > 0)
      cloud->push_back(point);
  return cloud;
}

/// About `points` of a cloud, evenly, starting with another one for each `offset`.
Cloud::Ptr cut(const Cloud& cloud, std::size_t points, std::size_t offset)
{
  const std::size_t step = std::max<std::size_t>(1, (cloud.size() + points / 2) / points);
  const Cloud::Ptr part(new Cloud);
  for (std::size_t i = offset % step; i < cloud.size(); i += step)
    part->push_back(cloud[i]);
  return part;
}

std::vector<Pair> pairsOf(const Options& options)
{
  const Pair street{load(options.scans + "/lidar_street_1.pcd"), load(options.scans + "/lidar_street_0.pcd")};
  const Pair room{load(options.scans + "/rgbd_room_1.pcd"), load(options.scans + "/rgbd_room_0.pcd")};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> logarithm(std::log(2e3), std::log(2.7e5));
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < options.pairs; ++i) {
    std::size_t points = 0;
    if (options.workload == "tiny")
      points = 64;
    else if (options.workload == "small")
      points = 7000;
    else if (options.workload == "large")
      points = 60'000;
    else
      points = static_cast<std::size_t>(std::exp(logarithm(random)));
    const Pair& scans = points > 65'000 || (options.workload == "mix" && i % 2 == 1) ? room : street;
    if (i % options.step == options.first)
      pairs.push_back({cut(*scans.source, points, i), cut(*scans.target, points, 3 * i + 1)});
  }
  return pairs;
}

/// Of all threads of the process.
double cpuMilliseconds() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double millisecondsSince(Clock::time_point start)
{
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

void configure(Ours& icp, const Options& options)
{
  icp.setCorrespondenceSearch(options.search == "device" ? pcl_gpu_icp::CorrespondenceSearch::DeviceKdTree
                                                         : pcl_gpu_icp::CorrespondenceSearch::PclKdTree);
  icp.setMaximumIterations(options.iterations);
}

/// One alignment after another.
template <typename Icp>
nlohmann::json inSequence(Icp& icp, const std::vector<Pair>& pairs)
{
  std::vector<double> finished;
  const double cpu = cpuMilliseconds();
  const auto start = Clock::now();
  for (const Pair& pair : pairs) {
    Cloud output;
    icp.setInputSource(pair.source);
    icp.setInputTarget(pair.target);
    icp.align(output);
    finished.push_back(millisecondsSince(start));
  }
  return {{"ms", millisecondsSince(start)}, {"cpu_ms", cpuMilliseconds() - cpu}, {"finished_ms", finished}};
}

/// Time in which at least one operation runs, and work-items in flight on average, over the time of all.
nlohmann::json utilisationOf(const pcl_gpu_icp::Schedule& schedule, double total_ms)
{
  auto spans = schedule.spans();
  std::sort(spans.begin(), spans.end(), [](const auto& a, const auto& b) { return a.begin_ms < b.begin_ms; });
  double busy = 0, until = 0, items = 0;
  for (const auto& span : spans) {
    if (span.what == "pair")
      continue;
    busy += std::max(0.0, span.end_ms - std::max(until, span.begin_ms));
    until = std::max(until, span.end_ms);
    items += (span.end_ms - span.begin_ms) * static_cast<double>(span.work_items);
  }
  return {{"busy", busy / total_ms}, {"work_items", items / total_ms}};
}

std::size_t residentKilobytes()
{
  std::ifstream file("/proc/self/statm");
  std::size_t size = 0, resident = 0;
  file >> size >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) / 1024;
}

std::ptrdiff_t openFiles()
{
  const std::filesystem::directory_iterator files("/proc/self/fd");
  return std::distance(begin(files), end(files));
}

pcl_gpu_icp::Policy policyNamed(const std::string& name)
{
  for (const auto policy : {pcl_gpu_icp::Policy::SmallestFirst,
                            pcl_gpu_icp::Policy::FirstComeFirstServed,
                            pcl_gpu_icp::Policy::LargestFirst})
    if (name == toString(policy))
      return policy;
  throw std::invalid_argument("no policy " + name);
}

nlohmann::json inBatch(const std::vector<Pair>& pairs, const Options& options)
{
  pcl_gpu_icp::BatchSettings settings;
  settings.lanes = options.lanes;
  settings.capacity = options.capacity;
  settings.policy = policyNamed(options.policy);
  const bool tiny = options.workload == "tiny";
  if (!tiny)
    settings.schedule = std::make_shared<pcl_gpu_icp::Schedule>();
  settings.keep_results = false;
  pcl_gpu_icp::BatchAligner batch;
  batch.setSettings(settings);
  for (const Pair& pair : pairs)
    batch.add<Point, Point>(pair.source, pair.target, [&options](Ours& icp) { configure(icp, options); });
  std::vector<std::size_t> memory;
  std::vector<std::ptrdiff_t> files;
  std::vector<double> finished;
  const double cpu = cpuMilliseconds();
  const auto start = Clock::now();
  batch.run([&](std::size_t /*pair*/, const pcl_gpu_icp::BatchResult& result) {
    if (!result.alignment.converged)
      throw std::runtime_error("a pair did not converge: " + result.alignment.message);
    finished.push_back(result.end_ms);
    if (!tiny || finished.size() % 100 != 0)
      return;
    memory.push_back(residentKilobytes());
    files.push_back(openFiles());
  });
  const double total = millisecondsSince(start);
  nlohmann::json json{{"ms", total}, {"cpu_ms", cpuMilliseconds() - cpu}};
  if (tiny) {
    json["resident_kb"] = memory;
    json["open_files"] = files;
  }
  else
    json["finished_ms"] = finished;
  if (settings.schedule)
    json["utilisation"] = utilisationOf(*settings.schedule, total);
  return json;
}

nlohmann::json run(const Options& options)
{
  std::vector<Pair> pairs = pairsOf(options);
  if (options.method == "stock") {
    Stock icp;
    icp.setMaximumIterations(options.iterations);
    return inSequence(icp, pairs);
  }
  // The device and the kernels are started before.
  const std::vector<Pair> few(1, {cut(*pairs.front().source, 100, 0), cut(*pairs.front().target, 100, 0)});
  if (options.method == "batch") {
    Options warm_up = options;
    warm_up.workload = "small";
    inBatch(few, warm_up);
    return inBatch(pairs, options);
  }
  Ours icp;
  configure(icp, options);
  inSequence(icp, few);
  return inSequence(icp, pairs);
}

} // namespace

int main(int count, char** arguments)
{
  Options options;
  CLI::App app("Aligns many cloud pairs by one method.");
  app.add_option("SCANS", options.scans)->required();
  app.add_option("WORKLOAD", options.workload)->required()->check(CLI::IsMember({"tiny", "small", "large", "mix"}));
  app.add_option("METHOD", options.method)->required()->check(CLI::IsMember({"stock", "sequence", "batch"}));
  app.add_option("--search", options.search)->check(CLI::IsMember({"pcl", "device"}));
  app.add_option("--policy", options.policy);
  app.add_option("--capacity", options.capacity);
  app.add_option("--lanes", options.lanes);
  app.add_option("--pairs", options.pairs);
  app.add_option("--first", options.first);
  app.add_option("--step", options.step);
  app.add_option("--iterations", options.iterations);
  CLI11_PARSE(app, count, arguments);
  try {
    std::cout << run(options).dump() << std::endl;
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "batch_benchmark: " << error.what() << "\n";
    return 1;
  }
}
