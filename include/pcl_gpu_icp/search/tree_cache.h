#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>

namespace pcl_gpu_icp::search {

/// Trees that several aligners search, by the fingerprint of their points. A tree lives while somebody holds it.
/// Thread-safe; who asks for a tree that another is building waits for it.
template <typename Tree>
class TreeCache {
public:
  /// \param build makes the tree where there is none
  std::shared_ptr<const Tree> get(std::uint64_t fingerprint, const std::function<std::shared_ptr<const Tree>()>& build)
  {
    const std::shared_ptr<Entry> entry = entryOf(fingerprint);
    const std::lock_guard<std::mutex> lock(entry->mutex);
    std::shared_ptr<const Tree> tree = entry->tree.lock();
    if (!tree)
      entry->tree = tree = build();
    return tree;
  }

private:
  struct Entry {
    std::mutex mutex;
    std::weak_ptr<const Tree> tree;
  };

  std::shared_ptr<Entry> entryOf(std::uint64_t fingerprint)
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
    return entry->tree.expired();
  }

  std::mutex mutex_;
  std::map<std::uint64_t, std::shared_ptr<Entry>> entries_;
};

} // namespace pcl_gpu_icp::search
