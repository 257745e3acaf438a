#include "harness.h"

#include "cli/guess.h"

#include <cmath>
#include <stdexcept>

using namespace pcl_gpu_icp;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  RigidTransform guess;
  try {
    guess = cli::parseGuess(fuzz::textOf(data, size));
  } catch (const std::invalid_argument& error) {
    fuzz::require(std::strlen(error.what()) > 10, "a refusal says what is wrong");
    return 0;
  }
  const RigidTransform rotation = nearestRigid(guess, {1, 2, 3});
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      double product = 0;
      for (int k = 0; k < 3; ++k)
        product += rotation.rotation[3 * i + k] * rotation.rotation[3 * j + k];
      fuzz::require(std::abs(product - (i == j)) < 1e-12, "a guess becomes a rotation");
      fuzz::require(std::abs(rotation.rotation[3 * i + j] - guess.rotation[3 * i + j]) < 1e-2,
                    "close to what was written");
    }
  return 0;
}
