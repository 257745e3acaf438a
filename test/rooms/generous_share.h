#pragma once

#include <pcl_gpu_icp/device_share.h>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace pcl_gpu_icp::test {

/// Grants everything and writes down what it was asked.
class GenerousShare : public DeviceShare {
public:
  explicit GenerousShare(std::size_t capacity)
  : capacity_(capacity)
  {
  }
  std::size_t capacity() const override { return capacity_; }
  Grant request(const char* /*operation*/, std::size_t work_items) override
  {
    EXPECT_FALSE(held_) << "nobody waits for more while holding some";
    held_ = true;
    log.push_back("request " + std::to_string(work_items));
    return ++grants_;
  }
  void narrow(Grant grant, const char* /*operation*/, std::size_t work_items) override
  {
    EXPECT_EQ(grant, grants_);
    log.push_back("narrow " + std::to_string(work_items));
  }
  void release(Grant grant) noexcept override
  {
    EXPECT_EQ(grant, grants_);
    held_ = false;
    log.push_back("release");
  }
  std::vector<std::string> log;

private:
  std::size_t capacity_;
  Grant grants_ = 0;
  bool held_ = false;
};

} // namespace pcl_gpu_icp::test
