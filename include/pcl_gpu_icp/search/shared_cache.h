#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>

namespace pcl_gpu_icp::search {

/// What several aligners use, by the fingerprint of what it is made of. A value lives while somebody holds it.
/// Thread-safe; who asks for a value that another is making waits for it.
template <typename Value, typename Fingerprint = std::uint64_t>
class SharedCache {
public:
  /// \param make makes the value where there is none
  std::shared_ptr<const Value> get(const Fingerprint& fingerprint,
                                   const std::function<std::shared_ptr<const Value>()>& make)
  {
    const std::shared_ptr<Entry> entry = entryOf(fingerprint);
    const std::lock_guard<std::mutex> lock(entry->mutex);
    std::shared_ptr<const Value> value = entry->value.lock();
    if (!value)
      entry->value = value = make();
    return value;
  }

private:
  struct Entry {
    std::mutex mutex;
    std::weak_ptr<const Value> value;
  };

  std::shared_ptr<Entry> entryOf(const Fingerprint& fingerprint)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (auto entry = entries_.begin(); entry != entries_.end();)
      entry = isUnused(entry->second) ? entries_.erase(entry) : std::next(entry);
    std::shared_ptr<Entry>& entry = entries_[fingerprint];
    if (!entry)
      entry = std::make_shared<Entry>();
    return entry;
  }

  static bool isUnused(const std::shared_ptr<Entry>& entry)
  {
    if (entry.use_count() > 1)
      return false;
    // Waits for nobody: it makes visible here what the last user wrote.
    const std::lock_guard<std::mutex> lock(entry->mutex);
    return entry->value.expired();
  }

  std::mutex mutex_;
  std::map<Fingerprint, std::shared_ptr<Entry>> entries_;
};

} // namespace pcl_gpu_icp::search
