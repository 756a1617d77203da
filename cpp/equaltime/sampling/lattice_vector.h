// The vector of the rank-1 lattice, for up to 2^20 points: made by tests/bench/lattice_vector.py, which
// says how it is constructed.
#pragma once

#include <cstdint>

#include "equaltime/sampling/dimensions.h"

namespace equaltime::lattice {

inline constexpr std::uint32_t kVector[kDimensions] = {
    1,        // pixel
    201433,   // pixel
    406757,   // direction 0
    946589,   // direction 0
    631665,   // choice 0
    853067,   // direction 1
    389449,   // direction 1
    94897,    // choice 1
    784033,   // direction 2
    526201,   // direction 2
    958767,   // choice 2
    116267,   // direction 3
    922925,   // direction 3
    475643,   // choice 3
    124541,   // direction 4
    1020951,  // direction 4
    913553,   // choice 4
    131779,   // direction 5
    259909,   // direction 5
    577997,   // choice 5
    647599,   // direction 6
    147691,   // direction 6
    963717,   // choice 6
    972525,   // direction 7
    963135,   // direction 7
    86983,    // choice 7
    909665,   // lens
    791279,   // lens
    934607,   // time
    807655,   // roulette 0
    492585,   // roulette 1
    545289,   // roulette 2
    698047,   // roulette 3
    356457,   // roulette 4
    729943,   // roulette 5
    37739,    // roulette 6
    107111,   // roulette 7
    890567,   // material 0
    431469,   // material 1
    934489,   // material 2
    541303,   // material 3
    456435,   // material 4
    673373,   // material 5
    82173,    // material 6
    616003,   // material 7
    956037,   // medium 0
    995993,   // medium 0
    202123,   // medium 1
    779555,   // medium 1
    477013,   // medium 2
    906903,   // medium 2
    758867,   // medium 3
    824581,   // medium 3
    4685,     // medium 4
    209549,   // medium 4
    311515,   // medium 5
    222831,   // medium 5
    451361,   // medium 6
    357549,   // medium 6
    587039,   // medium 7
    1505,     // medium 7
};

}  // namespace equaltime::lattice
