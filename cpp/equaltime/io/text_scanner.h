// Words and numbers of one line of text. Numbers are read by std::from_chars, so they are correctly rounded and do not
// depend on the locale. Never looks past the line, never throws.
#pragma once

#include <charconv>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>

namespace equaltime {

class TextScanner {
 public:
  explicit TextScanner(std::string_view line) noexcept : at_(line.data()), end_(line.data() + line.size()) {}

  // The next word, without the spaces round it; empty at the end of the line.
  std::string_view word() noexcept {
    skip_spaces();
    const char* const begin = at_;
    while (at_ != end_ && !is_space(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }

  // What is left of the line, without the spaces round it.
  std::string_view rest() noexcept {
    skip_spaces();
    std::string_view left(at_, static_cast<std::size_t>(end_ - at_));
    while (!left.empty() && is_space(left.back())) left.remove_suffix(1);
    at_ = end_;
    return left;
  }

  // The next word as a number (nan and inf included, overflow as inf); false, and nothing consumed, if it is not one.
  bool number(double& value) noexcept {
    skip_spaces();
    const char* const begin = at_ != end_ && *at_ == '+' && end_ - at_ > 1 && at_[1] != '-' ? at_ + 1 : at_;
    const auto [stop, error] = std::from_chars(begin, end_, value);
    if (error == std::errc::invalid_argument || (stop != end_ && !is_space(*stop))) return false;
    if (error == std::errc::result_out_of_range) value = out_of_range(begin, stop);
    at_ = stop;
    return true;
  }

  // The next word as an integer; false, and nothing consumed, if it is not one.
  bool integer(std::int64_t& value) noexcept {
    const char* const begin = (skip_spaces(), at_);
    if (!digits(value) || !(at_ == end_ || is_space(*at_))) return at_ = begin, false;
    return true;
  }

  // An integer right here, whatever follows it: the parts of "3/1/2".
  bool digits(std::int64_t& value) noexcept {
    const auto [stop, error] = std::from_chars(at_, end_, value);
    if (error != std::errc{}) return false;
    at_ = stop;
    return true;
  }
  bool take(char c) noexcept {
    if (at_ == end_ || *at_ != c) return false;
    return ++at_, true;
  }

  // True at a space or the end of the line.
  [[nodiscard]] bool word_ends() const noexcept { return at_ == end_ || is_space(*at_); }
  void skip_spaces() noexcept {
    while (at_ != end_ && is_space(*at_)) ++at_;
  }
  bool line_ends() noexcept {
    skip_spaces();
    return at_ == end_;
  }

  // The word at hand as an error shows it: quoted, cut, with control characters replaced. It may be no UTF-8.
  [[nodiscard]] std::string found() const { return quoted(TextScanner(*this).word()); }
  static std::string quoted(std::string_view text) {
    if (text.empty()) return "the end of the line";
    std::string shown = "'";
    for (const char c : text.substr(0, 32)) shown += static_cast<unsigned char>(c) < ' ' || c == '\x7f' ? '?' : c;
    return shown + (text.size() > 32 ? "…'" : "'");
  }

 private:
  static bool is_space(char c) noexcept { return c == ' ' || (c >= '\t' && c <= '\r'); }

  // from_chars leaves the value alone when it is out of range and does not say on which side: the decimal exponent of
  // the first digit that is not zero does.
  static double out_of_range(const char* at, const char* end) noexcept {
    const bool negative = *at == '-';
    long exponent = 0;
    bool point = false, nonzero = false;
    for (; at != end && *at != 'e' && *at != 'E'; ++at) {
      if (*at == '.') point = true;
      if (*at < '0' || *at > '9') continue;
      if (nonzero && !point) ++exponent;
      if (!nonzero && point) --exponent;
      nonzero = nonzero || *at != '0';
    }
    long written = 0;
    if (at != end) {
      const char* const digits = at + (end - at > 1 && at[1] == '+' ? 2 : 1);
      if (std::from_chars(digits, end, written).ec != std::errc{}) written = *digits == '-' ? -1000000 : 1000000;
    }
    const double size = exponent + written > 0 ? std::numeric_limits<double>::infinity() : 0.0;
    return negative ? -size : size;
  }

  const char* at_;
  const char* end_;
};

}  // namespace equaltime
