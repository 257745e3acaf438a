// What the program allocates memory and writes files with. Only its own calls fail, and those of the library that is
// tested: what OpenCL, PCL and the C library do for themselves is theirs to test.
#include "fault_point.h"
#include "faults.h"

#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <new>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

extern "C" void* __libc_malloc(std::size_t bytes);

namespace {

bool isTested(const void* caller)
{
  Dl_info where;
  if (dladdr(caller, &where) == 0 || !where.dli_fname)
    return false;
  const char* slash = std::strrchr(where.dli_fname, '/');
  const char* name = slash ? slash + 1 : where.dli_fname;
  return std::strstr(name, "pcl_gpu_icp") && !std::strstr(name, "faults");
}

/// errno to fail with, or 0.
int systemFailsNow(const char* function, const void* caller)
{
  if (!isTested(caller))
    return 0;
  const int code = faults::failsNow(function);
  if (code > 0)
    errno = code;
  return code;
}

bool allocationFails(std::size_t bytes, const void* caller)
{
  static thread_local bool inside = false; // counting allocates, too
  if (inside || bytes < faults::smallestBytes())
    return false;
  inside = true;
  const bool fails = systemFailsNow("allocate", caller) != 0;
  inside = false;
  return fails;
}

template <typename Function>
Function* real(Function* /*its own*/, const char* name)
{
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

} // namespace

#define REAL(name)                                                                                                     \
  (*[] {                                                                                                               \
    static const auto function = real(&name, #name);                                                                   \
    return function;                                                                                                   \
  }())
#define CALLER __builtin_return_address(0)
#define MAY_FAIL(name, parameters, ...)                                                                                \
  int name parameters { return systemFailsNow(#name, CALLER) ? -1 : REAL(name)(__VA_ARGS__); }

extern "C" {

MAY_FAIL(fsync, (int file), file)
MAY_FAIL(fchmod, (int file, mode_t mode), file, mode)
MAY_FAIL(ftruncate, (int file, off_t size) noexcept, file, size)
MAY_FAIL(flock, (int file, int how) noexcept, file, how)
MAY_FAIL(mkstemp, (char* name), name)
MAY_FAIL(mkdir, (const char* name, mode_t mode) noexcept, name, mode)
MAY_FAIL(rename, (const char* from, const char* to) noexcept, from, to)
MAY_FAIL(renameat2,
         (int from_at, const char* from, int to_at, const char* to, unsigned flags) noexcept,
         from_at,
         from,
         to_at,
         to,
         flags)

/// As Linux: the file is closed all the same.
int close(int file)
{
  const int failed = systemFailsNow("close", CALLER);
  const int result = REAL(close)(file);
  if (failed)
    errno = failed;
  return failed ? -1 : result;
}

int open(const char* name, int flags, ...)
{
  va_list more;
  va_start(more, flags);
  const mode_t mode = va_arg(more, mode_t);
  va_end(more);
  return systemFailsNow("open", CALLER) ? -1 : REAL(open)(name, flags, mode);
}

ssize_t write(int file, const void* data, size_t bytes)
{
  const int failed = systemFailsNow("write", CALLER);
  if (failed > 0)
    return -1;
  return REAL(write)(file, data, failed == faults::writes_half ? (bytes + 1) / 2 : bytes);
}

void* malloc(std::size_t bytes)
{
  if (allocationFails(bytes, CALLER)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_malloc(bytes);
}

} // extern "C"

void* operator new(std::size_t bytes)
{
  void* const memory = allocationFails(bytes, CALLER) ? nullptr : __libc_malloc(bytes);
  if (!memory)
    throw std::bad_alloc();
  return memory;
}
