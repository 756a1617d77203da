// Local means: the light around each pixel, which do not reach across edges. At an edge, one half of a neighbourhood is
// like the pixels next to the pixel, and the opposite half is not. Each of four halves counts by the likelihood that
// both have the same mean (edge-aligned halves: Lee 1981).
#pragma once

#include "equaltime/analysis/bands.h"

namespace equaltime {

/// Local means of all values of a band.
struct LocalMeans {
  Doubles means, others;  // with the pixel, and without it
  Doubles brightest;      // the brightest that is likely

  void fit(std::size_t size) {
    for (Doubles* values : {&means, &others, &brightest}) values->resize(size);
  }
  /// Finds them for all rows of the band.
  void find(const Band& band);
};

}  // namespace equaltime
