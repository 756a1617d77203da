// Tests without a library: TEST("a sentence") { CHECK(…); } and `int main() { return check::run(); }`.
#pragma once

#include <cstdio>
#include <exception>
#include <string>
#include <string_view>
#include <vector>

namespace check {

struct Test {
  const char* sentence;
  void (*body)();
};

inline std::vector<Test>& tests() {
  static std::vector<Test> all;
  return all;
}
inline int& failures() {
  static int count = 0;
  return count;
}

struct Register {
  Register(const char* sentence, void (*body)()) { tests().push_back({sentence, body}); }
};

inline void report(bool good, const char* file, int line, const std::string& what) {
  if (good) return;
  ++failures();
  std::printf("  %s:%d: %s\n", file, line, what.c_str());
}

// Whether f throws an E whose text contains `part`; says what happened instead.
template <typename E, typename F>
void throws(F&& f, std::string_view part, const char* file, int line) {
  try {
    f();
    report(false, file, line, "nothing was thrown");
  } catch (const E& error) {
    const std::string text = error.what();
    report(text.find(part) != std::string::npos, file, line, "the error says: " + text);
  }
}

inline int run() {
  for (const Test& test : tests()) {
    const int before = failures();
    try {
      test.body();
    } catch (const std::exception& error) {
      report(false, test.sentence, 0, std::string("unexpected exception: ") + error.what());
    }
    std::printf("%s %s\n", failures() == before ? "pass" : "FAIL", test.sentence);
  }
  return failures() == 0 ? 0 : 1;
}

}  // namespace check

#define CHECK_JOIN_(a, b) a##b
#define CHECK_NAME_(a, b) CHECK_JOIN_(a, b)
#define TEST(sentence)                                                                                    \
  static void CHECK_NAME_(test_, __LINE__)();                                                             \
  static const check::Register CHECK_NAME_(register_, __LINE__)(sentence, &CHECK_NAME_(test_, __LINE__)); \
  static void CHECK_NAME_(test_, __LINE__)()
#define CHECK(condition) check::report((condition), __FILE__, __LINE__, "not true: " #condition)
#define CHECK_THROWS(exception, part, expression) \
  check::throws<exception>([&] { (void)(expression); }, part, __FILE__, __LINE__)
