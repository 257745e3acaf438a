#pragma once

#include <cstdint>
#include <cstring>
#include <string>

namespace pcl_gpu_icp::fuzz {

/// Takes values off the front of an input; zeros when there are no more.
class Bytes {
public:
  Bytes(const std::uint8_t* data, std::size_t size)
  : data_(data)
  , left_(size)
  {
  }

  std::uint8_t byte()
  {
    if (left_ == 0)
      return 0;
    --left_;
    return *data_++;
  }

  /// From 0 to `most`, which a byte holds.
  unsigned upTo(unsigned most) { return byte() % (most + 1); }

  bool flag() { return (byte() & 1) != 0; }

  void fill(std::uint8_t* to, std::size_t count)
  {
    for (std::size_t i = 0; i < count; ++i)
      to[i] = byte();
  }

  bool empty() const { return left_ == 0; }

private:
  const std::uint8_t* data_;
  std::size_t left_;
};

} // namespace pcl_gpu_icp::fuzz
