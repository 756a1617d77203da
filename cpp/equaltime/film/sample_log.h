// SampleLog: the first 64 faulty samples. One bad material can make millions.
#pragma once

#include <array>
#include <cstddef>

namespace equaltime {

/// At most 64 entries, enough to replay some of each kind; further ones are dropped. Takes no memory of its own.
template <class Entry>
class SampleLog {
 public:
  void add(const Entry& entry) noexcept {
    if (size_ < entries_.size()) entries_[size_++] = entry;
  }
  void add(const SampleLog& other) noexcept {
    for (const Entry& entry : other) add(entry);
  }
  /// Drops all entries but the first `size`.
  void shrink(std::size_t size) noexcept { size_ = size; }

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] const Entry* begin() const noexcept { return entries_.data(); }
  [[nodiscard]] const Entry* end() const noexcept { return entries_.data() + size_; }

 private:
  std::array<Entry, 64> entries_;
  std::size_t size_ = 0;
};

}  // namespace equaltime
