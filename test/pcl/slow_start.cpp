// Makes PoCL's start take long, so that threads which start it at once meet in it: as a function of the program this
// comes before hwloc's, which PoCL asks about the machine.
#include <chrono>
#include <dlfcn.h>
#include <thread>

extern "C" __attribute__((visibility("default"))) int hwloc_topology_load(void* topology)
{
  using Load = int (*)(void*);
  const auto load = reinterpret_cast<Load>(dlsym(dlopen("libhwloc.so.15", RTLD_LAZY), "hwloc_topology_load"));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  return load ? load(topology) : -1;
}
