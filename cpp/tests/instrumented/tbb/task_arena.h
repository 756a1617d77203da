// See parallel_for.h: an arena holds as many threads as are asked for, without more ado.
#pragma once

namespace tbb {

struct task_arena {
  explicit task_arena(int) {}
  template <class F>
  void execute(F&& f) {
    f();
  }
};

}  // namespace tbb
