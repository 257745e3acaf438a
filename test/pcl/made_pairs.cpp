#include "made_pairs.h"

#include <pcl/common/point_tests.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <stdexcept>

namespace made_pairs {

namespace {

using Generator = std::mt19937;
using Eigen::Affine3d;
using Eigen::Vector3d;

double uniform(Generator& generator, double low, double high)
{
  return std::uniform_real_distribution<double>(low, high)(generator);
}

Vector3d anyVector(Generator& generator)
{
  std::normal_distribution<double> normal;
  Vector3d vector;
  for (double& x : vector)
    x = normal(generator);
  return vector;
}

Vector3d pointOf(const pcl::PointXYZ& point) { return point.getVector3fMap().cast<double>(); }

Vector3d centreOf(const Cloud& cloud)
{
  Vector3d sum = Vector3d::Zero();
  for (const auto& point : cloud)
    sum += pointOf(point);
  return sum / static_cast<double>(cloud.size());
}

double radiusOf(const Cloud& cloud)
{
  const Vector3d centre = centreOf(cloud);
  double sum = 0;
  for (const auto& point : cloud)
    sum += (pointOf(point) - centre).squaredNorm();
  return std::sqrt(sum / static_cast<double>(cloud.size()));
}

/// A turn about the cloud's centre and a shift, by shares of its radius, each in any direction.
Affine3d motion(Generator& generator, const Cloud& about, double degrees, double shift)
{
  const Vector3d centre = centreOf(about);
  const Vector3d axis = anyVector(generator).normalized(), along = anyVector(generator).normalized();
  return Eigen::Translation3d(centre + along * shift * radiusOf(about)) *
         Eigen::AngleAxisd(degrees * M_PI / 180, axis) * Eigen::Translation3d(-centre);
}

// Scenes of boxes, in metres, and what a scanner sees of them.

struct Box {
  Vector3d centre, half; ///< half its size
  double heading;        ///< radians about z
};
using Scene = std::vector<Box>;

/// Distance along the ray to the box, from outside or from inside; infinite: it is missed.
double distanceTo(const Box& box, const Vector3d& from, const Vector3d& along)
{
  const Eigen::AngleAxisd back(-box.heading, Vector3d::UnitZ());
  const Vector3d start = back * (from - box.centre), direction = back * along;
  constexpr double infinite = std::numeric_limits<double>::infinity();
  double enter = -infinite, leave = infinite;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (-box.half[axis] - start[axis]) / direction[axis];
    const double b = (box.half[axis] - start[axis]) / direction[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave || leave < 0)
    return infinite;
  return enter > 0 ? enter : leave;
}

Scene anyRoom(Generator& generator)
{
  const Vector3d half(uniform(generator, 2, 5), uniform(generator, 1.5, 4), uniform(generator, 1.2, 1.6));
  Scene scene{{{0, 0, half.z()}, half, 0}};
  const int things = static_cast<int>(uniform(generator, 4, 12));
  for (int i = 0; i < things; ++i) {
    const Vector3d size(uniform(generator, 0.15, 0.8), uniform(generator, 0.15, 0.6), uniform(generator, 0.2, 0.9));
    const double x = uniform(generator, -0.8, 0.8) * half.x(), y = uniform(generator, -0.8, 0.8) * half.y();
    const double heading = uniform(generator, 0, 1) < 0.6 ? 0 : uniform(generator, 0, M_PI);
    scene.push_back({{x, y, size.z()}, size, heading});
  }
  return scene;
}

Scene anyStreet(Generator& generator)
{
  Scene scene{{{0, 0, -10}, {200, 200, 10}, 0}}; // the ground
  for (const double side : {-1.0, 1.0})
    for (double x = -60; x < 60;) {
      const double length = uniform(generator, 5, 18), front = uniform(generator, 9, 13);
      scene.push_back({{x + length / 2, side * (front + 5), 6}, {length / 2, 5, uniform(generator, 6, 14)}, 0});
      x += length + uniform(generator, 0, 6);
    }
  const int things = static_cast<int>(uniform(generator, 8, 25));
  for (int i = 0; i < things; ++i) {
    const bool pole = uniform(generator, 0, 1) < 0.4;
    const Vector3d half = pole ? Vector3d(0.12, 0.12, 4) : Vector3d(2.1, 0.9, 0.75);
    const double x = uniform(generator, -50, 50), y = uniform(generator, 3, 8);
    const double side = uniform(generator, 0, 1) < 0.5 ? -1 : 1, heading = uniform(generator, -0.1, 0.1);
    scene.push_back({{x, side * y, half.z()}, half, heading});
  }
  return scene;
}

struct Scanner {
  int rings, columns;
  double range, noise; ///< metres
};

constexpr Scanner indoors{32, 240, 20, 0.005}, outdoors{40, 500, 60, 0.02};

/// In the scanner's own frame.
Cloud::Ptr scanned(const Scene& scene, const Affine3d& pose, const Scanner& scanner, Generator& generator)
{
  constexpr double lowest = -25, highest = 25; // degrees
  std::normal_distribution<double> noise(0, scanner.noise);
  const Cloud::Ptr cloud(new Cloud);
  for (int ring = 0; ring < scanner.rings; ++ring)
    for (int column = 0; column < scanner.columns; ++column) {
      const double elevation = (lowest + (highest - lowest) * ring / (scanner.rings - 1)) * M_PI / 180;
      const double azimuth = 2 * M_PI * column / scanner.columns;
      const Vector3d along(
          std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      double nearest = std::numeric_limits<double>::infinity();
      for (const Box& box : scene)
        nearest = std::min(nearest, distanceTo(box, pose.translation(), pose.rotation() * along));
      if (nearest > scanner.range)
        continue;
      pcl::PointXYZ& point = cloud->emplace_back();
      point.getVector3fMap() = (along * (nearest + noise(generator))).cast<float>();
    }
  return cloud;
}

Affine3d upright(Generator& generator, double x, double y)
{
  constexpr double height = 1.6;
  return Eigen::Translation3d(x, y, height) * Eigen::AngleAxisd(uniform(generator, 0, 2 * M_PI), Vector3d::UnitZ());
}

// Parts of scans.

/// Those between two shares of the points along a direction; four in five of them, with noise.
Cloud::Ptr cut(const Cloud& cloud, const Vector3d& along, double from, double to, double noise, Generator& generator)
{
  std::vector<double> places, sorted;
  for (const auto& point : cloud)
    places.push_back(along.dot(pointOf(point)));
  sorted = places;
  std::sort(sorted.begin(), sorted.end());
  const auto at = [&sorted](double share) {
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  };
  const double low = at(from), high = at(to);
  constexpr double kept = 0.8;
  const Cloud::Ptr part(new Cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (places[i] >= low && places[i] <= high && uniform(generator, 0, 1) < kept) {
      part->push_back(cloud[i]);
      part->back().getVector3fMap() += (noise * anyVector(generator)).cast<float>();
    }
  return part;
}

/// Voxel means about the first point, without what is not finite or a zero return.
Cloud::Ptr readScan(const std::string& file, float leaf)
{
  Cloud::Ptr cloud(new Cloud), finite(new Cloud);
  if (pcl::io::loadPCDFile(file, *cloud) != 0)
    throw std::runtime_error("cannot read " + file);
  for (const auto& point : *cloud)
    if (pcl::isFinite(point) && !point.getVector3fMap().isZero())
      finite->push_back(point);
  constexpr float far = 1e5F; // where float32 has no digits left for voxels
  const Eigen::Vector3f first = finite->front().getVector3fMap();
  if (first.norm() > far)
    for (auto& point : *finite)
      point.getVector3fMap() -= first;
  if (leaf <= 0)
    return finite;
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setLeafSize(leaf, leaf, leaf);
  grid.setInputCloud(finite);
  grid.filter(*cloud);
  return cloud;
}

Affine3d readTransform(const std::string& name)
{
  std::ifstream file(name);
  Affine3d transform;
  for (int i = 0; i < 16; ++i)
    file >> transform.matrix()(i / 4, i % 4);
  if (!file)
    throw std::runtime_error("cannot read " + name);
  return transform;
}

struct Scan {
  std::string name;
  Cloud::Ptr cloud;
};

class PairList {
public:
  explicit PairList(unsigned seed)
  : generator_(seed)
  {
  }

  void addScenes()
  {
    for (const bool is_room : {true, false}) {
      const auto anyScene = [&] { return is_room ? anyRoom(generator_) : anyStreet(generator_); };
      const Scanner& scanner = is_room ? indoors : outdoors;
      const double far = is_room ? 0.8 : 6;
      const Scene scene = anyScene();
      const Affine3d at = upright(generator_, uniform(generator_, -0.5, 0.5), uniform(generator_, -0.5, 0.5));
      const Cloud::Ptr target = scanned(scene, at, scanner, generator_);
      for (const double way : {0.0, uniform(generator_, 0, 0.3), uniform(generator_, 0.3, 1)}) {
        const Vector3d to =
            at.translation() + way * far * Vector3d(uniform(generator_, -1, 1), uniform(generator_, -0.4, 0.4), 0);
        const Affine3d from = upright(generator_, to.x(), to.y());
        add(is_room ? "simulated room" : "simulated street",
            is_room ? "room" : "street",
            scanned(scene, from, scanner, generator_),
            target,
            at.inverse() * from);
      }
      add("unrelated",
          is_room ? "another simulated room" : "another simulated street",
          scanned(anyScene(), upright(generator_, 0, 0), scanner, generator_),
          target);
    }
  }

  /// Hills that look alike in places, each cloud other points of them. \param overlap from 0 to 1
  void addHills(double overlap)
  {
    struct Wave {
      double height, along_x, along_y, phase;
    };
    std::vector<Wave> waves(3);
    for (Wave& wave : waves)
      wave = {uniform(generator_, 0.1, 0.4),
              uniform(generator_, -2, 2),
              uniform(generator_, -2, 2),
              uniform(generator_, 0, 2 * M_PI)};
    constexpr int points = 2000;
    constexpr double half = 2;
    const auto sampled = [&](double from, double to) {
      const Cloud::Ptr cloud(new Cloud);
      for (int i = 0; i < points; ++i) {
        const double x = uniform(generator_, from, to), y = uniform(generator_, -half, half);
        double z = 0;
        for (const Wave& wave : waves)
          z += wave.height * std::sin(wave.along_x * x + wave.along_y * y + wave.phase);
        cloud->push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
      }
      return cloud;
    };
    const double each = 2 * half / (2 - overlap);
    add("hills",
        "overlap " + std::to_string(static_cast<int>(std::lround(100 * overlap))),
        sampled(-half, each - half),
        sampled(half - each, half));
  }

  void addParts(const Scan& scan)
  {
    constexpr double of_the_radius = 0.002;
    const double noise = of_the_radius * radiusOf(*scan.cloud);
    const auto part = [&](const Vector3d& along, double from, double to, double by) {
      return cut(*scan.cloud, along.normalized(), from, to, by, generator_);
    };
    const auto anywhere = [&] { return anyVector(generator_); };
    add("copy", scan.name, part(anywhere(), 0, 1, 0), part(anywhere(), 0, 1, 0));
    for (const int percent : {20, 35, 50, 65, 80, 90}) {
      const Vector3d along = anywhere();
      const double each = 1 / (2 - percent / 100.0); // of the whole, so that they have so much of each in common
      add("overlap " + std::to_string(percent),
          scan.name,
          part(along, 0, each, noise),
          part(along, 1 - each, 1, noise));
    }
    add("part", scan.name, part(anywhere(), 0, uniform(generator_, 0.1, 0.5), noise), part(anywhere(), 0, 1, noise));
  }

  /// One cloud on another, of one size and about one place.
  void addUnrelated(const Scan& scan, const Scan& onto)
  {
    const auto scale = static_cast<float>(radiusOf(*onto.cloud) / radiusOf(*scan.cloud));
    const Eigen::Vector3f from = centreOf(*scan.cloud).cast<float>(), to = centreOf(*onto.cloud).cast<float>();
    const Cloud::Ptr source(new Cloud(*scan.cloud));
    for (auto& point : *source)
      point.getVector3fMap() = scale * (point.getVector3fMap() - from) + to;
    add("unrelated", scan.name + " onto " + onto.name, source, onto.cloud);
  }

  void add(const std::string& kind,
           const std::string& clouds,
           const Cloud::Ptr& source,
           const Cloud::Ptr& target,
           const Affine3d& truth = Affine3d::Identity())
  {
    // Small turns and shifts as often as large ones.
    const double degrees = std::exp(uniform(generator_, 0, std::log(180.0)));
    const double shift = std::exp(uniform(generator_, std::log(0.01), std::log(0.8)));
    pairs_.push_back({kind, clouds, source, target, truth, motion(generator_, *target, degrees, shift) * truth});
    pairs_.push_back({kind, clouds, source, target, truth, motion(generator_, *target, 1, 0.01) * truth});
  }

  std::vector<Pair> take() { return std::move(pairs_); }

private:
  Generator generator_;
  std::vector<Pair> pairs_;
};

} // namespace

std::vector<Pair> makePairs(const std::string& scans, int repetitions, unsigned seed)
{
  PairList list(seed);
  for (int repetition = 0; repetition < repetitions; ++repetition)
    list.addScenes();
  if (!std::filesystem::exists(scans))
    return list.take();

  const std::vector<Scan> read{{"bunny", readScan(scans + "/bunny_0.pcd", 0)},
                               {"street", readScan(scans + "/lidar_street_0.pcd", 0.3F)},
                               {"room", readScan(scans + "/rgbd_room_0.pcd", 0.03F)},
                               {"terrain", readScan(scans + "/terrain_utm.pcd", 20)}};
  const Cloud::Ptr next_street = readScan(scans + "/lidar_street_1.pcd", 0.3F);
  const Cloud::Ptr next_room = readScan(scans + "/rgbd_room_1.pcd", 0.03F);
  const Affine3d along_street = readTransform(scans + "/lidar_street_T_0_1.txt");
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    for (std::size_t i = 0; i < read.size(); ++i) {
      list.addParts(read[i]);
      list.addUnrelated(read[(i + 1 + static_cast<std::size_t>(repetition) % (read.size() - 1)) % read.size()],
                        read[i]);
    }
    list.add("shared", "street", next_street, read[1].cloud, along_street);
    list.add("shared", "room", next_room, read[2].cloud); // a quarter of a second apart: under a spacing
  }
  return list.take();
}

namespace {

/// Of two guesses the first; of those that have half or more in common.
std::vector<Pair> relatedOnce(std::vector<Pair> pairs)
{
  std::vector<Pair> related;
  for (std::size_t i = 0; i < pairs.size(); i += 2)
    if (pairs[i].isRelated() && pairs[i].kind != "overlap 20" && pairs[i].kind != "overlap 35")
      related.push_back(std::move(pairs[i]));
  return related;
}

} // namespace

std::vector<Pair> makeNearbyPairs(const std::string& scans, int repetitions, unsigned seed)
{
  std::vector<Pair> nearby = relatedOnce(makePairs(scans, repetitions, seed));
  Generator generator(seed);
  for (Pair& pair : nearby) {
    const double degrees = uniform(generator, 0, 30), shift = uniform(generator, 0, 0.25);
    pair.guess = motion(generator, *pair.target, degrees, shift) * pair.truth;
  }
  return nearby;
}

std::vector<Pair> makeFarPairs(const std::string& scans, int repetitions, unsigned seed)
{
  std::vector<Pair> pairs = makePairs(scans, repetitions, seed);
  PairList hills(seed);
  for (int repetition = 0; repetition < repetitions; ++repetition)
    for (const double overlap : {0.65, 0.8, 1.0})
      hills.addHills(overlap);
  for (Pair& pair : hills.take())
    pairs.push_back(std::move(pair));
  std::vector<Pair> far = relatedOnce(std::move(pairs));
  Generator generator(seed);
  for (Pair& pair : far) {
    const Vector3d centre = centreOf(*pair.target), along = anyVector(generator).normalized();
    std::normal_distribution<double> normal;
    const double w = normal(generator), x = normal(generator), y = normal(generator), z = normal(generator);
    const double shift = uniform(generator, 0, 2.5) * radiusOf(*pair.target);
    pair.guess = Eigen::Translation3d(centre + shift * along) * Eigen::Quaterniond(w, x, y, z).normalized() *
                 Eigen::Translation3d(-centre) * pair.truth;
  }
  return far;
}

double errorOf(const Pair& pair, const Eigen::Affine3d& answer)
{
  double sum = 0;
  for (const auto& point : *pair.source)
    sum += (answer * pointOf(point) - pair.truth * pointOf(point)).squaredNorm();
  return std::sqrt(sum / static_cast<double>(pair.source->size()));
}

} // namespace made_pairs
