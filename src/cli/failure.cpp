#include "cli/failure.h"

#include <pcl_gpu_icp/error.h>

#include <new>

namespace pcl_gpu_icp::cli {

Failure failureOf(const std::exception_ptr& error)
{
  try {
    std::rethrow_exception(error);
  } catch (const Failure& failure) {
    return failure;
  } catch (const DeviceError& device) {
    return {ExitCode::Device, device.what()};
  } catch (const InvalidArgument& argument) {
    return {ExitCode::Input, argument.what()};
  } catch (const std::bad_alloc&) {
    return {ExitCode::Internal, "out of memory"};
  } catch (const std::exception& other) {
    return {ExitCode::Internal, std::string("internal error: ") + other.what()};
  } catch (...) {
    return {ExitCode::Internal, "internal error: an exception that is no std::exception"};
  }
}

} // namespace pcl_gpu_icp::cli
