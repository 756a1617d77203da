// A file read front to back through one small window, and lines on top of it. Reading rather than mapping: a file that
// is cut while it is read ends early instead of killing the process, and memory stays at one window.
#pragma once

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "equaltime/io/mesh_data.h"

namespace equaltime {

class FileBytes {
 public:
  explicit FileBytes(const std::filesystem::path& path) : path_(path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) throw MeshError(path.string() + ": no such file");
    // Opening a pipe would wait for a writer for ever.
    if (!std::filesystem::is_regular_file(status)) throw MeshError(path.string() + ": not a regular file");
    file_.reset(std::fopen(path.c_str(), "rb"));
    size_ = file_ ? std::filesystem::file_size(path, error) : 0;
    if (!file_ || error) throw MeshError(path.string() + ": cannot be opened: " + std::strerror(errno));
    std::setvbuf(file_.get(), nullptr, _IONBF, 0);
  }

  // Makes n unread bytes available, or as many as the file still has; returns how many there are now.
  std::size_t ensure(std::size_t n) {
    if (end_ - begin_ < n) fill(n);
    return end_ - begin_;
  }
  [[nodiscard]] const char* data() const noexcept { return buffer_.data() + begin_; }
  [[nodiscard]] std::size_t available() const noexcept { return end_ - begin_; }
  void advance(std::size_t n) noexcept { begin_ += n, offset_ += n; }

  // Steps over n bytes, whether or not they are in the window; returns false if the file ends before.
  bool skip(std::uint64_t n) {
    while (n > 0) {
      const std::size_t step = static_cast<std::size_t>(std::min<std::uint64_t>(n, ensure(1)));
      if (step == 0) return false;
      advance(step), n -= step;
    }
    return true;
  }

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  [[nodiscard]] std::uint64_t offset() const noexcept { return offset_; }
  // By the size that the file had when it was opened: what a declared count is checked against before memory is taken.
  [[nodiscard]] std::uint64_t remaining() const noexcept { return size_ > offset_ ? size_ - offset_ : 0; }

 private:
  static constexpr std::size_t kWindow = std::size_t{1} << 20;

  void fill(std::size_t n) {
    std::copy(data(), data() + available(), buffer_.data());
    end_ -= begin_, begin_ = 0;
    const std::uint64_t want = std::max<std::uint64_t>(n, kWindow);
    buffer_.resize(std::max(buffer_.size(), static_cast<std::size_t>(std::min(want, remaining() + 1))));
    while (end_ < std::min(n, buffer_.size())) {
      const std::size_t got = std::fread(buffer_.data() + end_, 1, buffer_.size() - end_, file_.get());
      if (got == 0 && std::ferror(file_.get())) {
        throw MeshError(path_.string() + ": cannot be read: " + std::strerror(errno));
      }
      if (got == 0) return;
      end_ += got;
    }
  }

  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> file_;
  std::uint64_t size_ = 0, offset_ = 0;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;
};

// The lines of a text, without their ends: \n, \r\n or a lone \r, each wherever it stands. Counts from 1.
//
// The end of the first line is what most lines have. It alone ends the window that is looked at, so that a header in
// text stops where binary data begins. The other end is looked for once in each window, not in each line.
class Lines {
 public:
  explicit Lines(FileBytes& bytes) : bytes_(bytes) {
    std::size_t looked = 0;
    while (looked < kLongestFirstLine && bytes_.ensure(looked + 2) > looked) {
      const char c = bytes_.data()[looked++];
      if (c == '\n') return;
      if (c != '\r') continue;
      if (looked == bytes_.available() || bytes_.data()[looked] != '\n') separator_ = '\r', other_ = '\n';
      return;
    }
  }

  // The next line, valid until the next call; false at the end of the file.
  bool next(std::string_view& line) {
    bytes_.advance(std::exchange(consumed_, 0));
    const std::size_t length = find_other(find_separator());
    const std::size_t available = bytes_.available();
    if (available == 0) return false;
    ++number_;
    consumed_ = std::min(length + 1, available);
    line = {bytes_.data(), length};
    if (separator_ == '\n' && length + 1 < available && bytes_.data()[length] == '\r' &&
        bytes_.data()[length + 1] == '\n') {
      ++consumed_;
    }
    return true;
  }

  // The byte after the line that was returned last becomes the next one of the file: for binary data after a header.
  void release() { bytes_.advance(std::exchange(consumed_, 0)); }

  [[nodiscard]] std::uint64_t number() const noexcept { return number_; }
  [[nodiscard]] std::string place() const {
    return bytes_.path().string() + (number_ == 0 ? "" : ":" + std::to_string(number_)) + ": ";
  }
  [[noreturn]] void fail(const std::string& message) const { throw MeshError(place() + message); }

 private:
  // How far the next separator is. It is kept, since other ends may come before.
  std::size_t find_separator() {
    if (separator_end_ > bytes_.offset()) return static_cast<std::size_t>(separator_end_ - 1 - bytes_.offset());
    std::size_t looked = 0;
    for (std::size_t have = bytes_.ensure(1); looked < have; have = bytes_.ensure(2 * have)) {
      if (const void* hit = std::memchr(bytes_.data() + looked, separator_, have - looked)) {
        looked = static_cast<std::size_t>(static_cast<const char*>(hit) - bytes_.data());
        break;
      }
      looked = have;
    }
    separator_end_ = bytes_.offset() + looked + 1;
    return looked;
  }

  // How far the next end of a line of the other kind is, or `length` if that is less.
  std::size_t find_other(std::size_t length) {
    const std::uint64_t here = bytes_.offset();
    clear_until_ = std::max(clear_until_, here);
    while (clear_until_ < here + length) {
      const auto looked = static_cast<std::size_t>(clear_until_ - here);
      if (bytes_.data()[looked] == other_) return looked;
      const void* hit = std::memchr(bytes_.data() + looked, other_, bytes_.available() - looked);
      clear_until_ =
          here + (hit ? static_cast<std::size_t>(static_cast<const char*>(hit) - bytes_.data()) : bytes_.available());
    }
    return length;
  }

  static constexpr std::size_t kLongestFirstLine = 1 << 16;  // after that it is \n, whatever comes

  FileBytes& bytes_;
  char separator_ = '\n', other_ = '\r';
  // Places in the file: after the separator that was found last, and up to where no other end stands.
  std::uint64_t separator_end_ = 0, clear_until_ = 0;
  std::size_t consumed_ = 0;
  std::uint64_t number_ = 0;
};

}  // namespace equaltime
