// The account of a mesh file: what it says that does not reach the mesh, told in one line for each kind. A reader uses
// each statement or property of its file, refuses it with its place, or enters it here; it ends by entering all that it
// has not consumed. No entry but the first of its kind allocates.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "equaltime/io/text_scanner.h"

namespace equaltime {

class WordAccount {
 public:
  /// Enters `count` more of a `word` of the file; `what` is the rest of the sentence, a literal. Lines count from 1.
  void tell(std::string_view word, std::string_view what, std::uint64_t line, std::uint64_t count = 1) {
    if (count == 0) return;
    const auto same = [&](const Entry& e) { return e.what == what && e.word == word.substr(0, kLongestWord); };
    if (const auto known = std::find_if(entries_.begin(), entries_.end(), same); known != entries_.end()) {
      known->count += count;
    } else if (entries_.size() < kMostKinds) {
      entries_.push_back({std::string(word.substr(0, kLongestWord)), what, line, count});
    } else {
      untold_ += count;
    }
  }

  /// Adds the lines to what there is to tell: "line 5: 'l' is not rendered (first of 4)".
  void add_to(std::vector<std::string>& warnings) const {
    for (const Entry& e : entries_) {
      const std::string first_of = e.count > 1 ? " (first of " + std::to_string(e.count) + ")" : "";
      warnings.push_back("line " + std::to_string(e.line) + ": " + TextScanner::quoted(e.word) + " " +
                         std::string(e.what) + first_of);
    }
    if (untold_ > 0) {
      warnings.push_back("and " + std::to_string(untold_) + " more statements of other kinds are not used");
    }
  }

 private:
  struct Entry {
    std::string word;
    std::string_view what;
    std::uint64_t line, count;
  };
  static constexpr std::size_t kMostKinds = 30;    // a file with more is broken all over
  static constexpr std::size_t kLongestWord = 64;  // words are quoted, and may be very long

  std::vector<Entry> entries_;
  std::uint64_t untold_ = 0;
};

}  // namespace equaltime
