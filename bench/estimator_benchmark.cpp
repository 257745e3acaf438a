// The estimator alone, against both SVD paths of stock PCL: from PCL points to a transform, and its kernels against
// the memory bandwidth that a kernel that only reads the same buffer reaches.
#include "opencl/context.h"
#include "opencl/queue.h"
#include "stages/launch.h"
#include "stages/listed_pairs.h"
#include "stages/pack.h"

#include "kernels/layout.h"

#include <pcl_gpu_icp/transformation_estimation_svd.h>

#include <pcl/point_types.h>
#include <pcl/registration/transformation_estimation_svd.h>

#include <benchmark/benchmark.h>

#include <random>

namespace {

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;
namespace opencl = pcl_gpu_icp::opencl;
namespace stages = pcl_gpu_icp::stages;
using pcl_gpu_icp::Pipeline;
using pcl_gpu_icp::Precision;

/// A 20 m slab and the same, turned and shifted.
struct Pairs {
  explicit Pairs(std::size_t n)
  : source(n, 1)
  , target(n, 1)
  {
    std::mt19937 generator(1);
    std::uniform_real_distribution<float> wide(-10, 10), flat(-1, 1);
    const float c = std::cos(0.3F), s = std::sin(0.3F);
    for (std::size_t i = 0; i < n; ++i) {
      const float x = wide(generator), y = wide(generator), z = flat(generator);
      source[i] = Point(x, y, z);
      target[i] = Point(c * x - s * y + 1, s * x + c * y + 2, z + 3);
    }
  }
  Cloud source, target;
};

template <typename Estimator>
void fromPointsToTransform(benchmark::State& state, const Estimator& estimator)
{
  const Pairs pairs(state.range(0));
  Eigen::Matrix4f transform;
  estimator.estimateRigidTransformation(pairs.source, pairs.target, transform); // start-up is not counted
  for (auto _ : state) {
    estimator.estimateRigidTransformation(pairs.source, pairs.target, transform);
    benchmark::DoNotOptimize(transform.data());
  }
  state.counters["pairs/s"] = benchmark::Counter(double(state.range(0)), benchmark::Counter::kIsIterationInvariantRate);
}

void stockUmeyama(benchmark::State& state)
{
  fromPointsToTransform(state, pcl::registration::TransformationEstimationSVD<Point, Point>(true));
}

void stockCorrelation(benchmark::State& state)
{
  fromPointsToTransform(state, pcl::registration::TransformationEstimationSVD<Point, Point>(false));
}

template <Pipeline pipeline>
void ours(benchmark::State& state)
{
  pcl_gpu_icp::TransformationEstimationSVD<Point, Point> estimator;
  estimator.setPipeline(pipeline);
  fromPointsToTransform(state, estimator);
}

/// Runs `enqueue` on pairs that lie on the device and reports the device's own time.
template <typename Enqueue>
void onDevice(benchmark::State& state, Precision precision, Enqueue enqueue)
{
  const auto device = pcl_gpu_icp::Device::select();
  const auto traits = opencl::Traits::of(device.info());
  if (precision == Precision::Double && !traits.fp64) {
    state.SkipWithError("the device has no fp64");
    return;
  }
  opencl::Queue queue(device, traits, stages::buildOptions(traits, precision));
  const Pairs clouds(state.range(0));
  stages::Pairs pairs;
  const auto source = pcl_gpu_icp::search::pointsOf(clouds.source),
             target = pcl_gpu_icp::search::pointsOf(clouds.target);
  stages::packPairs(queue, source, target, stages::placementOf(source), stages::placementOf(target), pairs);
  enqueue(queue, pairs);
  queue.takeProfile();
  for (auto _ : state) {
    enqueue(queue, pairs);
    double milliseconds = 0;
    for (const auto& [stage, time] : queue.takeProfile().entries)
      milliseconds += time.milliseconds;
    state.SetIterationTime(milliseconds * 1e-3);
  }
  state.SetBytesProcessed(std::int64_t(state.iterations()) * state.range(0) * 6 * sizeof(float));
}

template <Precision precision>
void listedPairsKernels(benchmark::State& state)
{
  stages::ListedPairs listed;
  opencl::Buffer solution{"solution"};
  onDevice(state, precision, [&](opencl::Queue& queue, const stages::Pairs& pairs) {
    queue.reserve(solution, sizeof(RigidSolution<double>));
    listed.enqueue(queue, pairs, precision == Precision::Double ? sizeof(double) : sizeof(float), solution);
  });
}

/// The floor: a kernel that reads the pairs and does nothing but add them up.
void readBandwidth(benchmark::State& state)
{
  opencl::Buffer sums{"sums"};
  cl::Kernel kernel;
  const auto context = &opencl::Context::of(pcl_gpu_icp::Device::select());
  const char* source = R"(
    kernel void read_all(global const float16* restrict values, uint vectors, uint chunk, global float16* sums)
    {
      const uint begin = get_global_id(0) * chunk, end = min(begin + chunk, vectors);
      float16 sum = 0;
      for (uint i = begin; i < end; ++i)
        sum += values[i];
      sums[get_global_id(0)] = sum;
    })";
  cl::Program program(context->handle(), source);
  program.build(context->device(), "-cl-std=CL1.2");
  cl::CommandQueue queue(context->handle(), context->device(), CL_QUEUE_PROFILING_ENABLE);
  kernel = cl::Kernel(program, "read_all");
  const cl_uint vectors = cl_uint(state.range(0) * 6 / 16);
  // A chunk for each compute unit of a CPU, a vector or two for each work-item of a GPU.
  const bool cpu = context->info().type == pcl_gpu_icp::DeviceInfo::Type::Cpu;
  const cl_uint items = cpu ? context->info().compute_units * 4 : std::max<cl_uint>(1, vectors / 2);
  const cl_uint chunk = (vectors + items - 1) / items;
  std::vector<float> values(std::size_t(vectors) * 16, 1.0F);
  cl::Buffer input(
      context->handle(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, values.size() * sizeof(float), values.data());
  cl::Buffer output(context->handle(), CL_MEM_WRITE_ONLY, std::size_t(items) * 64);
  kernel.setArg(0, input);
  kernel.setArg(1, vectors);
  kernel.setArg(2, chunk);
  kernel.setArg(3, output);
  for (auto _ : state) {
    cl::Event event;
    queue.enqueueNDRangeKernel(
        kernel, cl::NullRange, cl::NDRange(items), cpu ? cl::NDRange(1) : cl::NullRange, nullptr, &event);
    event.wait();
    state.SetIterationTime(1e-9 * double(event.getProfilingInfo<CL_PROFILING_COMMAND_END>() -
                                         event.getProfilingInfo<CL_PROFILING_COMMAND_START>()));
  }
  state.SetBytesProcessed(std::int64_t(state.iterations()) * std::int64_t(values.size() * sizeof(float)));
}

} // namespace

BENCHMARK(stockUmeyama)->Arg(100000)->Arg(1000000)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(stockCorrelation)->Arg(100000)->Arg(1000000)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(ours, Pipeline::Fused)->Arg(100000)->Arg(1000000)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(ours, Pipeline::Staged)->Arg(100000)->Arg(1000000)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(listedPairsKernels, Precision::Double)
    ->Arg(100000)
    ->Arg(1000000)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(listedPairsKernels, Precision::Float)
    ->Arg(100000)
    ->Arg(1000000)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(readBandwidth)->Arg(100000)->Arg(1000000)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_MAIN();
